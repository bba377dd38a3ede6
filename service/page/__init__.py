"""The web page at ``/``, where results are looked at: static files; nothing is computed here."""

from service.page import endpoints
from service.page.files import PLOTLY, STATIC, page_file

ROUTERS = (endpoints.router,)

__all__ = ["PLOTLY", "ROUTERS", "STATIC", "page_file"]
