"""The instruments of the demo study.

Q1-Q6 and their five labelled points are the paper's (supplement, “Questionnaire for Subject
Analysis”). Age and gender are reported in the paper; the wording and all other items are ours.
"""

from __future__ import annotations

from study.protocol.questionnaires import (
    DECLINED,
    AgreeItem,
    ChoiceItem,
    Instrument,
    NumberItem,
    Option,
    ScaleItem,
    TextItem,
)

AGREEMENT = (
    Option(value="1", label="Strongly disagree"),
    Option(value="2", label="Somewhat disagree"),
    Option(value="3", label="Neutral"),
    Option(value="4", label="Somewhat agree"),
    Option(value="5", label="Strongly agree"),
)
DECLINE = Option(value=DECLINED, label="Prefer not to say")

CONSENT = Instrument(
    name="consent",
    title="Your consent",
    items=(
        AgreeItem(name="adult", label="I am at least 18 years old."),
        AgreeItem(
            name="informed",
            label="I have read the information above and know whom to ask if I have questions.",
        ),
        AgreeItem(
            name="agreed",
            label="I take part of my own free will and agree to the recording described above.",
        ),
    ),
)

DEMOGRAPHICS = Instrument(
    name="demographics",
    title="About you",
    introduction="These answers describe who took part as a group. You need not give any of them.",
    items=(
        NumberItem(
            name="age",
            label="How old are you?",
            lowest=18,
            highest=120,
            unit="years",
            may_decline=True,
        ),
        ChoiceItem(
            name="gender",
            label="What is your gender?",
            options=(
                Option(value="woman", label="Woman"),
                Option(value="man", label="Man"),
                Option(value="non_binary", label="Non-binary"),
                Option(value="another", label="Another gender"),
                DECLINE,
            ),
        ),
        ChoiceItem(
            name="games_3d",
            label="How often do you play 3D video games?",
            options=(
                Option(value="never", label="Never or hardly ever"),
                Option(value="monthly", label="A few times a month"),
                Option(value="weekly", label="A few times a week"),
                Option(value="daily", label="Daily"),
                DECLINE,
            ),
        ),
        ChoiceItem(
            name="colour_vision",
            label="Do you have difficulty telling colours apart?",
            help="The displays use colours; every robot also carries a number.",
            options=(
                Option(value="no", label="No"),
                Option(value="yes", label="Yes"),
                Option(value="unsure", label="I do not know"),
                DECLINE,
            ),
        ),
    ),
)

QUESTIONNAIRE = Instrument(
    name="questionnaire",
    title="About this round",
    introduction="Think of the round that you have just finished. How far do you agree?",
    items=tuple(
        ScaleItem(name=name, label=label, options=AGREEMENT)
        for name, label in (
            ("Q1", "The tasks were easy to understand."),
            (
                "Q2",
                (
                    "The tasks were not mentally demanding, e.g., remembering, deciding, thinking, "
                    "etc."
                ),
            ),
            (
                "Q3",
                "I enjoyed using the system and would like to use such a system in the future.",
            ),
            ("Q4", "It was easy to keep track of robot status."),
            ("Q5", "The visualizations proved helpful in completing the tasks."),
            ("Q6", "The visualizations were not distracting."),
        )
    ),
)

COMMENTS = Instrument(
    name="comments",
    title="Anything else?",
    introduction="Both questions are optional. Send the page to finish the study.",
    items=(
        TextItem(
            name="problems",
            label="Did anything not work, or was anything unclear?",
            longest=2000,
        ),
        TextItem(
            name="remarks",
            label="Which display helped you most, and why?",
            help="You met display A, B and C, in this order.",
            longest=2000,
        ),
    ),
)
