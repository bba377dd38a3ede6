"""The page at the root: where results are looked at; static files, and nothing is computed."""

from service.page.files import PLOTLY, STATIC, page_file

__all__ = ["PLOTLY", "STATIC", "page_file"]
