"""Texts of studies as HTML: Markdown without raw HTML, cleaned once more before it is shown.

Headings begin at the second level, since each page has a title. Links open apart, so that nothing
typed on the page is lost. Pictures are left out: a page loads nothing from elsewhere.
"""

from __future__ import annotations

import functools

import nh3
from markdown_it import MarkdownIt
from markupsafe import Markup

_BLOCKS = {"p", "h2", "h3", "h4", "ul", "ol", "li", "blockquote", "hr", "table"}
_BLOCKS |= {"thead", "tbody", "tr", "th", "td", "pre"}
_WORDS = {"a", "em", "strong", "code", "br", "s"}
_PARSER = MarkdownIt("commonmark", {"html": False}).enable("table").disable("image")
_LOWEST_HEADING = 4


@functools.lru_cache(maxsize=512)
def render_markdown(text: str) -> Markup:
    """A whole text with its headings, paragraphs and lists."""
    tokens = _PARSER.parse(text)
    for token in tokens:
        if token.type in ("heading_open", "heading_close"):
            level = min(max(2, int(token.tag[1])), _LOWEST_HEADING)
            token.tag = f"h{level}"
    html = _PARSER.renderer.render(tokens, _PARSER.options, {})
    return _clean(html, _BLOCKS | _WORDS)


@functools.lru_cache(maxsize=512)
def render_line(text: str) -> Markup:
    """One paragraph's worth of text, without the paragraph around it."""
    return _clean(_PARSER.renderInline(text), _WORDS)


def _clean(html: str, tags: set[str]) -> Markup:
    cleaned = nh3.clean(
        html,
        tags=tags,
        attributes={"a": {"href", "title"}, "ol": {"start"}},
        url_schemes={"http", "https", "mailto"},
        link_rel="noopener noreferrer",
        set_tag_attribute_values={"a": {"target": "_blank"}},
    )
    return Markup(cleaned)  # noqa: S704 - cleaned on the line above
