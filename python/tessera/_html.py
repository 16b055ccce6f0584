"""What notebooks show: tables and bars, in HTML."""
from __future__ import annotations

import html
import typing


def table(title: str, rows: typing.Mapping[str, object]) -> str:
    """Returns a table with a row for each name and value; empty values are left out. Nothing in it is taken for HTML."""
    lines = "".join(f'<tr><th style="text-align:left">{html.escape(name)}</th><td style="text-align:left">{html.escape(text)}</td></tr>'
                    for name, text in ((name, number(value)) for name, value in rows.items()) if text)
    return f"<div><strong>{html.escape(title)}</strong><table>{lines}</table></div>"


def number(value: object) -> str:
    """Returns a value as text; integers with commas between thousands."""
    if value is None:
        return ""
    return f"{value:,}" if isinstance(value, int) else str(value)


def bar(share: float, text: str) -> str:
    """Returns a bar that is filled to `share`, from 0 to 1, and a text beside it."""
    return f'<div><progress value="{min(max(share, 0.0), 1.0):.4f}" max="1" style="width:20em"></progress> {html.escape(text)}</div>'
