"""What pages and pictures use of Plotly, or the line that says how to install it."""

from __future__ import annotations

from hnav.errors import HnavValueError

try:
    import plotly.graph_objects as go
    from plotly.offline import get_plotlyjs
    from plotly.subplots import make_subplots
except ImportError:
    raise HnavValueError("option", "the report needs Plotly: python -m pip install plotly (the extra 'report')") from None

__all__ = ["get_plotlyjs", "go", "make_subplots"]
