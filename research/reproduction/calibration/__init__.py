"""Bodies and readings under which the vanilla controllers do what the paper says of them.

The paper prints no body. What it says of V and of Fig. 4 is a measurement of one, though: each
statement becomes a score (`scores`), many readings are tried (`measure`, `run`), and those that
agree best are a sample of the posterior (`posterior`). Nothing that is learned plays a part, so
that the claims about learned controllers are held out.
"""
