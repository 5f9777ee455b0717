"""Safety: what keeps an arm and the people at it from harm while it runs.

`plausibility` judges readings, `scene_watch` object poses, `force_watch` feels people; the `supervisor` says go on,
slow down or stop, `watch` puts them together for one pursuit; `stopping` and `yielding` are how a run ends or gives
way.
"""
