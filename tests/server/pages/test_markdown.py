"""Guards texts of studies: Markdown is shown as meant, and nothing in it can run or load."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.pages.markdown import render_line, render_markdown

HOSTILE = [
    "<script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "[x](javascript:alert(1))",
    "[x](data:text/html;base64,PHNjcmlwdD4=)",
    "[x](vbscript:x)",
    "![x](https://evil.example/pixel.png)",
    '<a href="https://evil.example" onclick="x()">x</a>',
    "<style>body{display:none}</style>",
    "<iframe src=https://evil.example></iframe>",
    "<form action=https://evil.example><input name=p></form>",
    "<javascript:alert(1)>",
    '[x](https://a.example "t\\" onmouseover=alert(1) x=\\"")',
]
TAGS = {"p", "h2", "h3", "h4", "ul", "ol", "li", "blockquote", "hr", "table", "thead", "tbody"}
TAGS |= {"tr", "th", "td", "pre", "a", "em", "strong", "code", "br"}
ATTRIBUTES = {"href", "title", "target", "rel", "start"}


class Reader(HTMLParser):
    """Collects what a browser would find in a piece of HTML and should not."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.wrong: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.wrong += [tag] if tag not in TAGS else []
        for name, value in attrs:
            scheme = re.match(r"[a-z]+(?=:)", value or "") if name == "href" else None
            safe = scheme is None or scheme[0] in ("http", "https", "mailto")
            self.wrong += [f"{name}={value}"] if name not in ATTRIBUTES or not safe else []


@pytest.mark.parametrize("text", HOSTILE)
def test_nothing_in_a_text_runs_or_loads(text: str) -> None:
    for html in (render_markdown(text), render_line(text), render_markdown(f"* {text}")):
        assert Reader(html).wrong == []


@given(st.text(alphabet="<>\"'&`[]()!*_#\\ \nabjscript:=/", max_size=80))
def test_whatever_is_written_no_tag_comes_out_but_ours(text: str) -> None:
    assert Reader(render_markdown(text)).wrong == []


def test_a_text_has_headings_below_the_pages_title_lists_and_emphasis() -> None:
    html = render_markdown(
        "# One\n\nSome *words*.\n\n* a\n* b\n\n##### Deep\n\n| a |\n|---|\n| 1 |"
    )
    for part in ("<h2>One</h2>", "<em>words</em>", "<li>a</li>", "<h4>Deep</h4>", "<td>1</td>"):
        assert part in html
    assert "<h1" not in html


def test_a_link_opens_apart_and_tells_nobody_where_it_was() -> None:
    html = render_line("See [this](https://a.example/x).")
    assert 'href="https://a.example/x"' in html
    assert 'target="_blank"' in html
    assert 'rel="noopener noreferrer"' in html


def test_a_line_has_no_paragraph_around_it() -> None:
    assert render_line("a **b** & “c”") == "a <strong>b</strong> &amp; “c”"
