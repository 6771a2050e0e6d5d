"""Result documents: one module a kind of result, its JSON Schema beside it."""
