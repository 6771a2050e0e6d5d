"""The thesis's own procedure, reproduced: models, elimination, tables, document and figures."""
