"""HTML pages from the templates of this folder, which share `page.html` and `tables.html`."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def rendered(template: str, **values: Any) -> str:
    """The page of a template; texts in it are escaped."""
    # imported here: start-up time
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folder = FileSystemLoader(Path(__file__).parent)
    environment = Environment(autoescape=True, undefined=StrictUndefined, loader=folder)
    return environment.get_template(template).render(**values)
