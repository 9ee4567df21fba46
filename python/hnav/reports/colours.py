"""The colours of pictures and pages: those of Okabe and Ito (Color Universal Design, 2008), which people with any kind of colour
vision can distinguish. Labels or line styles repeat the meaning of each colour."""

BLUE, VERMILION, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"
SKY, INK, FAINT = "#56B4E9", "#222222", "#8A8A8A"
AXIS_COLOURS = (VERMILION, GREEN, BLUE)
STATE_COLOURS = {"late": SKY, "outlier": ORANGE, "stuck": PURPLE, "saturated": VERMILION, "missing": FAINT}
