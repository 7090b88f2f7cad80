"""The paper's claims, one sentence and one number each, in every way to count the same results.

`atomic` is the list of them, fixed before any run that judges them. An effect (`effects`) is
computed from a study's table (`estimates`, its intervals by `resampling`) in each way to count
(`counting`), or from the table of an experiment beside the study (`kept`); `findings` says what
comes of it.
"""
