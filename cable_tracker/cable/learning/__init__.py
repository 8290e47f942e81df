"""The tables of the likelihood ratio, learnt from labelled frames."""
