"""The texts of the demo study. All wording here is ours, but for the items Q1-Q6 (paper)."""

from __future__ import annotations

from study.protocol.texts import ElementText, PageText, Section, StudyTexts

WELCOME = PageText(
    title="Working with a team of robots",
    lead="Help a team of delivery robots in a simulated warehouse, and tell us how well the "
    "display of your augmented-reality glasses supported you.",
    sections=(
        Section(
            heading="What to expect",
            points=(
                "A short practice, then three rounds in a 3D warehouse in this browser window.",
                "Each round takes about 7 minutes and is followed by six short questions.",
                "Altogether about 45 minutes. You can take breaks between the rounds.",
            ),
        ),
        Section(
            heading="What you need",
            points=(
                "A desktop or laptop computer with a keyboard and a mouse or trackpad.",
                "A current version of Chrome, Edge, Firefox or Safari. Nothing is installed.",
                "A quiet place in which nobody needs you for the time of a round.",
            ),
        ),
    ),
)

CONSENT = PageText(
    title="Information and consent",
    lead="Please read this page before you decide whether to take part.",
    sections=(
        Section(
            heading="What the study is about",
            paragraphs=(
                (
                    "In warehouses, people and teams of robots work side by side. Glasses for "
                    "augmented reality can show where the robots are and what they are about to do. "
                    "We compare different ways of showing this. There are no right or wrong answers, "
                    "and it is the displays that are tested, not you."
                ),
            ),
        ),
        Section(
            heading="What you will do",
            points=(
                (
                    "Check that your computer can show the 3D warehouse, and tell us a little about "
                    "yourself."
                ),
                "Practise walking in the warehouse until you have helped one robot.",
                (
                    "Work through three rounds, each with a different display, and answer six "
                    "questions after each of them."
                ),
            ),
        ),
        Section(
            heading="What is recorded",
            paragraphs=(
                (
                    "We store your answers, your movements inside the simulated warehouse, what the "
                    "display showed, and technical facts such as the frame rate. We store neither "
                    "your name nor your internet address, and we use neither camera nor microphone."
                ),
                (
                    "Your data are kept under a random code. If you came from a recruitment panel, "
                    "the panel's number for you is kept apart from the research data and serves only "
                    "to have you paid."
                ),
            ),
        ),
        Section(
            heading="Risks and benefits",
            paragraphs=(
                (
                    "Moving through a 3D scene can make some people feel slightly dizzy or sick. "
                    "Stop at once if that happens to you. Apart from this there are no risks beyond "
                    "those of ordinary computer use. You will have no direct benefit beyond what the "
                    "invitation promised."
                ),
            ),
        ),
        Section(
            heading="Taking part is voluntary",
            paragraphs=(
                (
                    "You may stop at any moment without giving a reason: the link “Withdraw” is at "
                    "the foot of every page. Data of people who withdraw are left out of the "
                    "analysis."
                ),
            ),
        ),
    ),
)

BROWSER_CHECK = PageText(
    title="Can your computer show the warehouse?",
    lead="This page checks your keyboard, your mouse and your graphics. Please follow the list "
    "below until every point is ticked.",
)

INSTRUCTIONS = PageText(
    title="Your task",
    lead="You are the only person in a warehouse in which robots collect boxes. The robots can "
    "drive, but they cannot unload: that is your part.",
    sections=(
        Section(
            heading="What the robots do",
            points=(
                (
                    "Each robot drives to a shelf, picks a box and brings it to one of the four drop "
                    "stations in the corners of the hall."
                ),
                "There it waits until you come. It cannot go on without you.",
                (
                    "When all its boxes are delivered, it drives home. The round ends as soon as "
                    "every robot is home."
                ),
            ),
        ),
        Section(
            heading="What you do",
            points=(
                (
                    "Walk to a robot that waits at a drop station. As soon as you are within one "
                    "metre of it, its box is unloaded by itself; there is no button to press."
                ),
                "Try to keep the time that robots wait as short as you can.",
                "Robots drive around you. You cannot walk through robots, shelves or walls.",
                (
                    "A robot cannot leave its place at the station while you stand right in front of "
                    "it: step aside when its box is gone."
                ),
            ),
        ),
        Section(
            heading="Practice first",
            paragraphs=(
                (
                    "You start in a small hall with a single robot and one box, and without any "
                    "display. Unload its box and let it drive home within three minutes. You have "
                    "three tries."
                ),
            ),
        ),
    ),
)

ELEMENTS = (
    ElementText(
        name="trajectory",
        title="Path on the floor",
        text="A ribbon in the robot's colour lies on the floor along the way that the robot is "
        "about to drive. Its width changes along the way and shows how near the goal is.",
        picture_alt="A coloured ribbon runs over the floor from a robot towards its goal.",
    ),
    ElementText(
        name="live-location",
        title="Robot seen through shelves",
        text="The robot is drawn in its colour where it really is, even when shelves are in "
        "between.",
        picture_alt="The solid shape of a robot in its colour is visible through a loaded shelf.",
    ),
    ElementText(
        name="transparent-avatar",
        title="Gliding ghost robot",
        text="A translucent copy of the robot glides along the planned path again and again and "
        "shows the direction of travel.",
        picture_alt="A translucent copy of a robot glides ahead of it along its planned path.",
    ),
    ElementText(
        name="balloon",
        title="Balloon above a drop station",
        text="A big red balloon floats above a drop station to call you there. You can see it "
        "from afar, above the shelves.",
        picture_alt="A big red balloon with a label floats above a drop station behind shelves.",
    ),
    ElementText(
        name="minimap",
        title="Map",
        text="A round map at the lower left shows you in the middle, where you look, and the "
        "robots as dots in their colours. It turns with you.",
        picture_alt="A round map at the lower left shows the view wedge and coloured dots.",
    ),
    ElementText(
        name="offscreen-arrows",
        title="Arrows at the edge",
        text="For each robot outside your view an arrow in its colour at the edge of the picture "
        "points to where it is.",
        picture_alt="Coloured arrows at the edges of the view point to robots outside it.",
    ),
    ElementText(
        name="path-beads",
        title="Beads along the path",
        text="Small spheres stand at the turning points of a robot's planned path.",
        picture_alt="A planned path is drawn as a line with a sphere at each of its turns.",
    ),
)

DEBRIEF = PageText(
    title="Thank you!",
    lead="You have completed the study. Everything you did and answered is stored.",
    sections=(
        Section(
            heading="What this was about",
            paragraphs=(
                (
                    "You worked with three displays in random order. One of them decided for every "
                    "robot and every station, second by second, what to show; the other two always "
                    "showed the same elements. We ask whether a display that leaves out what is not "
                    "needed at the moment lets people help their robots faster, and how they like "
                    "it."
                ),
                "Please do not tell others who may still take part how the displays differed.",
            ),
        ),
    ),
)

SCREENED_OUT = PageText(
    title="Thank you for trying",
    lead="The practice could not be completed in the given tries, so the study ends here for you.",
    sections=(
        Section(
            paragraphs=(
                (
                    "This is no judgement of you: slow graphics or an unfamiliar keyboard are the "
                    "most common reasons. Your practice is not part of the results."
                ),
            )
        ),
    ),
)

WITHDRAWN = PageText(
    title="You have withdrawn",
    lead="The study has ended for you. Thank you for the time that you gave us.",
    sections=(
        Section(
            paragraphs=(
                (
                    "What was recorded until now is marked as withdrawn and left out of the analysis. "
                    "To have it erased altogether, write to the researchers and give the participant "
                    "code below."
                ),
            )
        ),
    ),
)

TIMED_OUT = PageText(
    title="Your place was given away",
    lead="We heard nothing from you for a long time, so the study has ended for you.",
    sections=(
        Section(
            paragraphs=(
                (
                    "What you had sent is stored. If something went wrong on our side, please write "
                    "to the researchers and give the participant code below."
                ),
            )
        ),
    ),
)

TEXTS = StudyTexts(
    welcome=WELCOME,
    consent=CONSENT,
    browser_check=BROWSER_CHECK,
    instructions=INSTRUCTIONS,
    practice_failed="The robot was not back home in time. Read the task once more, then try again.",
    elements=ELEMENTS,
    adaptive_display="This display decides from moment to moment which of these elements to show "
    "for which robot and which station. Elements therefore appear and disappear during the round.",
    steady_display="This display shows these elements for every robot all the time, as long as "
    "there is something to show: a robot that stands still has no path.",
    plain_display="In this round no display helps you: you see the robots only where they are.",
    debrief=DEBRIEF,
    screened_out=SCREENED_OUT,
    withdrawn=WITHDRAWN,
    timed_out=TIMED_OUT,
    contact="the person who sent you the link to this study",
)
