"""Links to a daemon's viewer."""
from __future__ import annotations

import html
import typing


class ViewerLink(typing.NamedTuple):
    """The page of a daemon that draws a result, from Client.view(). Notebooks show it as a link."""

    name: str
    """The name of the result."""
    address: str
    """The page asks for a token when the browser has not seen one yet."""

    def _repr_html_(self) -> str:
        return (f'<a href="{html.escape(self.address)}" target="_blank" rel="noopener">'
                f"View {html.escape(self.name)}</a>")
