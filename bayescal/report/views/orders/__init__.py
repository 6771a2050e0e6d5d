"""A comparison of orders: one module per topic; `bayescal.report.views.comparison` lists them."""
