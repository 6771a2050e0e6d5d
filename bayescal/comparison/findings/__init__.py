"""What stands against a verdict or limits it: one list, made once, said by every outlet.

A kind of finding is one module with a function from a `Case` to findings, and one line in
`bayescal.comparison.findings.kinds`.
"""
