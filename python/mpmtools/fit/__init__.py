"""The paper's study: from tables of runs to its regressions, scores and the numbers behind its figures."""
