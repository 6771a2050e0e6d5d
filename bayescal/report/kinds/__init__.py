"""The kinds of result, one module each; `bayescal.report.runs` lists them."""
