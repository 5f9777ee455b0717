"""Reports: what a reader sees of demonstrations, tubes, beliefs and runs, as pictures, a video and rows of tables.

Above everything that makes these data, below the command line that prints them. Pictures: `plot_tubes`, `plot_belief`,
`plot_seam`, `plot_stiffness` and their kin take plain data and a path (.png, .pdf, .svg); `write_video` takes frames.
Rows are plain mappings, a column per key. `report.check` looks over a robot or task; it alone needs the simulator.
"""

from pft_exec.report.belief import plot_belief, plot_beliefs
from pft_exec.report.contents import FileContents, plot_contents, read_contents
from pft_exec.report.paths import plot_demonstrations
from pft_exec.report.seam import plot_log, plot_run, plot_seam
from pft_exec.report.stiffness import plot_stiffness
from pft_exec.report.stream import StreamRecognition, hold_out, recognize_stream
from pft_exec.report.tables import decision_rows, demonstration_rows, log_rows, log_summary, recognition_rows
from pft_exec.report.tubes import plot_tubes, tube_surface
from pft_exec.report.video import write_video

__all__ = [
    "FileContents",
    "StreamRecognition",
    "decision_rows",
    "demonstration_rows",
    "hold_out",
    "log_rows",
    "log_summary",
    "plot_belief",
    "plot_beliefs",
    "plot_contents",
    "plot_demonstrations",
    "plot_log",
    "plot_run",
    "plot_seam",
    "plot_stiffness",
    "plot_tubes",
    "read_contents",
    "recognition_rows",
    "recognize_stream",
    "tube_surface",
    "write_video",
]
