"""The outcome of a batch."""

__all__ = ["BatchError", "Report"]


class BatchError(RuntimeError):
    """A batch of which something is missing; `report` has what there is."""

    def __init__(self, report):
        super().__init__(str(report))
        self.report = report

    def __reduce__(self):
        return BatchError, (self.report,)


class Report:
    """The outcome of a batch.

    `crcs` holds the CRC-32 of each item's pixels (or of its result) by number, `values` the results
    of `map`. `failed` holds the message of each item that could not be drawn, `stopped` why the
    batch was ended early (a full disk, a cancellation), or None. `verified` counts the items that a
    second worker drew with the same bytes, `accused` names workers that were left out and why,
    `redrawn` counts what was drawn again for that. `workers` counts items by worker, `cost` is the
    mean time of one in seconds, `seconds` the whole time, `tasks` the tasks of the scheduler.
    """

    def __init__(self, count):
        self.count = count
        self.there = 0
        self.crcs = {}
        self.values = None
        self.failed = {}
        self.stopped = None
        self.verified = 0
        self.accused = {}
        self.redrawn = 0
        self.workers = {}
        self.cost = 0.0
        self.seconds = 0.0
        self.tasks = 0
        self.notes = []

    @property
    def missing(self):
        """Number of items that are not there."""
        return self.count - len(self.crcs)

    def end(self, errors):
        """Returns the report, or raises it if something is missing."""
        if errors == "raise" and self.missing:
            raise BatchError(self)
        return self

    def __str__(self):
        lines = ["%d of %d are there" % (len(self.crcs), self.count)]
        if self.there:
            lines[0] += ", %d from before" % self.there
        if self.stopped:
            lines.append("stopped: %s; the same call goes on from here" % self.stopped)
        for index in sorted(self.failed)[:10]:
            lines.append("%d failed: %s" % (index, self.failed[index]))
        if len(self.failed) > 10:
            lines.append("and %d more failed" % (len(self.failed) - 10))
        for worker, why in self.accused.items():
            lines.append("%s was left out: %s" % (worker, why))
        if self.redrawn:
            lines.append("%d drawn again for that" % self.redrawn)
        if self.verified:
            lines.append("%d drawn by a second worker, with the same bytes" % self.verified)
        return "; ".join(lines + self.notes)

    def __repr__(self):
        return "<fbptr.batch.Report: %s>" % self
