"""Words that the project does not use, and the field's words for them."""

NAMES = {
    "brought": "output",
    "crew": "pool",
    "dear": "slow",
    "heard": "signals",
    "judged": "evaluated",
    "posture": "initial_pose",
    "shelf": "cache",
    "struck": "impulse",
    "told": "formatted",
    "troupe": "pool",
    "variety": "randomization",
    "yardstick": "evaluation_set",
}
"""Not in any name of the package."""

PROSE = {
    r"tells|told|(?<!too small to )tell": "report, say, name or show",
    r"brings?|brought": "give, add or cause",
    r"dear(er|est)?": "slow or expensive",
    r"yardsticks?": "evaluation set",
    r"troupes?|crews?|shelf|shelves": "pool or cache",
    r"misfortunes?": "disturbance",
    r"c[ao]m(e|es|ing) (out|about)": "result or emerge",
    r"mend(s|ed|ing)?": "fix or repair",
    r"nobody|somebody": "name who",
    r"foret(ell|ells|old)": "predict",
    r"whoever|whosoever|whatsoever": "name who or what",
    r"what it is(?=\s*([|,.:;]|$))": "meaning or content",
    r"(^|(?<=[.:;|!] )|(?<=# )|(?<=\*\*))What (is|was|are|were)\b(?![^.!]*\?)": "name the subject",
}
"""Not in any text for people; patterns of whole words, without regard to case where they have
small letters alone."""
