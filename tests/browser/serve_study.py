"""Serves a study made for browser tests: every hall at practice scale, the world twice as fast.

Settings come from the environment, as for the real command. Argument: `walk`, or `demo` for the
demo study as it is shipped.
"""

from __future__ import annotations

import sys

from server.cli.context import read_settings
from server.serving import serve
from server.study_files import ReadStudy
from study.config import Study
from study.files.demo import paper_study


def walk_study() -> Study:
    """The demo study in a hall small enough to be played by software rendering."""
    return paper_study().revised(study_id="walk", scale="practice", recruiting="pilot")


if __name__ == "__main__":
    studies = {"walk": walk_study, "demo": paper_study}
    serve(read_settings(), [ReadStudy(studies[sys.argv[1]]())])
