"""The claims over what the paper leaves open: the study under many readings of the paper.

The paper prints no body, no definition of work, no release, no unit of ΔΩ. Each choice of all of
these is a reading of the paper (`readings`). Under each of a few dozen, models that the
claims are about are trained and evaluated (`plan`, run like a study), the claims are judged
(`verdicts`), and it is asked how often a claim is reproduced and which choice decides that
(`influence`). The idea is the multiverse analysis of Steegen et al. (2016), the picture the
specification curve of Simonsohn et al. (2020).
"""
