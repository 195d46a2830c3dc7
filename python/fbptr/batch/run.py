"""The loop of a batch: chunks over the workers of a Dask client, or one by one in this process.

Scheduling is Dask's: where a task runs, what a dead worker's tasks become, how data travels. This
loop decides how many items a task has, which items a second worker draws, and what to believe.

Promise: each result is taken once, by the calling thread. Whatever a worker does, items are taken,
failed or missing, and the report says which.
"""

import collections
import queue
import sys
import time

from .. import __version__
from .tasks import chunk as draw_chunk
from .tasks import prove

__all__ = ["run"]

# Tasks in flight for each thread of the workers: one that runs, and one that is there when it ends.
IN_FLIGHT = 2
# Times that an item is tried again because a worker died with it.
MOST_DEATHS = 5
# Seconds for which the list of workers is good.
LISTED = 1.0
# Seconds after which a result that does not arrive is looked into.
FETCHED = 3.0
# Seconds for which a worker that died may come back, if all others are left out.
PATIENCE = 30.0
# Seconds after which a cancellation is looked for.
WAIT = 0.2


def run(job, todo, client, report, sink, *, verify, retries, chunk, chunk_seconds, progress, cancel):
    """Draws the items `todo`, pairs of a number and a parameter, and fills the report."""
    begun = time.perf_counter()
    loop = _Loop(job, todo, report, sink, verify, retries, chunk, chunk_seconds, _shown(progress), cancel)
    try:
        if client is None:
            loop.here()
        else:
            loop.over(client)
    finally:
        report.seconds = time.perf_counter() - begun
        if loop.costs:
            report.cost = loop.spent / loop.costs


def _shown(progress):
    """Returns a function of (done, all) that shows the progress."""
    if callable(progress):
        return progress
    if progress is False or not sys.stderr.isatty():
        return lambda done, count: None

    def show(done, count):
        end = "\n" if done >= count else ""
        print("\r%d/%d" % (done, count), end=end, file=sys.stderr, flush=True)

    return show


class _Loop:
    def __init__(self, job, todo, report, sink, verify, retries, size, seconds, show, cancel):
        self.job, self.report, self.sink, self.verify = job, report, sink, verify
        self.retries, self.size, self.seconds, self.show, self.cancel = retries, size, seconds, show, cancel
        self.waiting = collections.deque(todo)
        self.params = dict(todo)
        # Spread over the batch, and so that a batch of a few items has one.
        self.samples = {index for i, (index, _) in enumerate(todo) if verify and i % verify == 0}
        self.attempts = collections.Counter()
        self.deaths = collections.Counter()
        self.drawn_by = {}
        self.costs, self.spent = 0, 0.0

    def is_over(self):
        """Returns whether nothing more is to be begun."""
        if self.cancel is not None and self.cancel.is_set():
            self.report.stopped = self.report.stopped or "cancelled"
        return self.report.stopped is not None

    def take(self, part):
        """Takes what a worker has drawn."""
        report = self.report
        for index, crc, value, seconds in part.done:
            if index in report.crcs:
                continue
            try:
                self.sink.take(index, value, seconds, part.host)
            except OSError as error:
                report.stopped = report.stopped or str(error)
                continue
            report.crcs[index] = crc
            report.failed.pop(index, None)
            report.workers[part.worker] = report.workers.get(part.worker, 0) + 1
            self.drawn_by[index] = part.worker
            self.costs, self.spent = self.costs + 1, self.spent + seconds
        for index, message in part.failed:
            self.attempts[index] += 1
            if self.attempts[index] > self.retries:
                report.failed[index] = message
            else:
                self.waiting.append((index, self.params[index]))
        if part.full:
            report.stopped = report.stopped or part.full
        self.show(len(report.crcs), report.count)

    def here(self):
        """Draws everything in this process."""
        while self.waiting and not self.is_over():
            self.take(draw_chunk(self.job, [self.waiting.popleft()], __version__))
        if self.verify and self.report.crcs:
            self.report.notes.append("not verified: one process has no second worker")

    def over(self, client):
        """Draws everything on the workers of a client."""
        _Cluster(self, client).run()


class _Cluster:
    """The tasks of a loop on a cluster."""

    def __init__(self, loop, client):
        self.loop, self.client, self.report = loop, client, loop.report
        self.tasks = {}
        self.proofs = {}
        self.to_prove = collections.deque()
        self.failures = collections.Counter()
        # Threads of each worker, and when they were asked for.
        self.listed, self.asked = {}, float("-inf")
        # Workers that were ever there, and since when none of them may draw.
        self.seen, self.idle_since = set(), None
        # Workers that a task is bound to.
        self.bound = {}
        # Futures that have ended, put there by Dask's threads.
        self.done = queue.SimpleQueue()

    def run(self):
        loop = self.loop
        # Sent once; each worker then has it, so that the death of one loses nothing.
        self.job = self.client.scatter(loop.job, broadcast=True, hash=False)
        try:
            self.begin()
            while self.tasks or self.proofs or (loop.waiting and not loop.is_over()):
                for future in self._next():
                    self.finished(future)
                if loop.is_over() and self.report.stopped == "cancelled":
                    break
                self.begin()
        except KeyboardInterrupt:
            self.report.stopped = "interrupted"
            raise
        finally:
            self.client.cancel([*self.tasks, *self.proofs])
            self.job = None
            if self.to_prove:
                self.report.notes.append("%d not verified: no second worker" % len(self.to_prove))

    def _next(self):
        """Waits for futures that end; at times for none, so that a cancellation is seen."""
        try:
            ended = [self.done.get(timeout=WAIT)]
        except queue.Empty:
            ended = []
        while not self.done.empty():
            ended.append(self.done.get())
        if time.monotonic() - self.asked > LISTED:
            self.workers()
            self.unbind()
        return ended

    def workers(self):
        """Returns the threads of each worker that may draw."""
        if time.monotonic() - self.asked > LISTED:
            info = self.client.scheduler_info(n_workers=-1)["workers"]
            self.listed = {address: worker["nthreads"] for address, worker in info.items()}
            self.seen.update(info)
            self.asked = time.monotonic()
        return {address: n for address, n in self.listed.items() if address not in self.report.accused}

    def unbind(self):
        """Puts back tasks that are bound to workers of which none lives: they would wait for ever."""
        for future, bound in list(self.bound.items()):
            if not any(address in self.listed for address in bound):
                self.client.cancel([future])
                del self.bound[future]
                self.again(self.tasks.pop(future, None), self.proofs.pop(future, None))

    def submit(self, function, *args, workers=None, priority=0):
        self.report.tasks += 1
        # Names of workers are given only if one is left out: the scheduler is free otherwise.
        future = self.client.submit(function, self.job, *args, __version__, pure=False, workers=workers,
                                    allow_other_workers=False, priority=priority)  # fmt: skip
        if workers is not None:
            self.bound[future] = workers
        future.add_done_callback(self.done.put)
        return future

    def begin(self):
        """Submits chunks and proofs, as many as keep the workers at work."""
        loop = self.loop
        if loop.is_over() or not (loop.waiting or self.to_prove):
            return
        workers = self.workers()
        if not workers and self.report.accused:
            # Where none is there at all, one may come back; where one died, too, but not for ever.
            now = time.monotonic()
            self.idle_since = self.idle_since or now
            has_died = bool(self.seen - set(self.listed) - set(self.report.accused))
            if self.listed and not (has_died and now - self.idle_since < PATIENCE):
                self.report.stopped = "every worker was left out"
            return
        self.idle_since = None
        threads = max(sum(workers.values()), 1)
        chosen = list(workers) if self.report.accused else None
        for _ in range(len(self.to_prove)):
            index = self.to_prove.popleft()
            others = [address for address in workers if address != loop.drawn_by.get(index)]
            if not others:
                self.to_prove.append(index)
                break
            future = self.submit(prove, index, loop.params[index], workers=others, priority=1)
            self.proofs[future] = index
        while loop.waiting and len(self.tasks) < threads * IN_FLIGHT:
            items = self.next_chunk(threads)
            future = self.submit(draw_chunk, items, workers=chosen)
            self.tasks[future] = items

    def next_chunk(self, threads):
        """Takes items for a task: as many as take the time of one, by the cost so far, and no more
        than each thread's part of a quarter of what is left, so that all end together."""
        loop = self.loop
        if loop.size is not None:
            count = loop.size
        elif not loop.costs:
            count = 1
        else:
            fitting = loop.seconds / max(loop.spent / loop.costs, 1e-6)
            count = min(fitting, len(loop.waiting) / (4 * threads))
        first = loop.waiting[0][0]
        # What failed, or was on a worker that died, is tried alone.
        if loop.attempts[first] or loop.deaths[first]:
            count = 1
        count = max(1, min(int(count), len(loop.waiting)))
        return [loop.waiting.popleft() for _ in range(count)]

    def finished(self, future):
        """Takes what became of a task."""
        items = self.tasks.pop(future, None)
        index = self.proofs.pop(future, None)
        bound = self.bound.pop(future, None)
        if items is None and index is None:
            # It was put back.
            return
        try:
            has_failed = future.status in ("error", "cancelled")
            part = None if has_failed else self.fetched(future, bound)
            why = None if part is not None else future.exception()
        except Exception as error:
            part, why = None, error
        if part is None:
            self.lost(items, index, why)
        elif part.version != __version__:
            self.accuse(part.worker, "version %s, expected %s" % (part.version, __version__))
            self.again(items, index)
        elif part.worker in self.report.accused:
            self.again(items, index)
        elif index is not None:
            self.compare(index, part)
        else:
            self.took(items, part)

    def fetched(self, future, bound):
        """Returns the result of a task that has ended. If its worker dies before the result is here,
        Dask runs the task again, but one that is bound to dead workers never: that raises."""
        while True:
            try:
                return future.result(timeout=FETCHED)
            except TimeoutError:
                self.workers()
                if bound is not None and not any(address in self.listed for address in bound):
                    self.client.cancel([future])
                    raise

    def again(self, items, index):
        """Puts back what a task was to do."""
        if index is not None:
            self.to_prove.append(index)
        self.loop.waiting.extendleft(reversed(items or []))

    def took(self, items, part):
        loop = self.loop
        loop.take(part)
        answered = {index for index, *_ in part.done} | {index for index, _ in part.failed}
        if part.full is None:
            loop.waiting.extend(item for item in items if item[0] not in answered)
        for index, *_ in part.done:
            if index in loop.samples and index in self.report.crcs:
                self.to_prove.append(index)

    def lost(self, items, index, why):
        """Takes a task that has no result: its worker died too often, or the job was lost."""
        loop = self.loop
        reason = "%s: %s" % (type(why).__name__, why)
        if index is not None:
            items = []
            loop.deaths[index] += 1
            if loop.deaths[index] <= MOST_DEATHS:
                self.to_prove.append(index)
        for item in items:
            loop.deaths[item[0]] += 1
            if loop.deaths[item[0]] > MOST_DEATHS:
                self.report.failed[item[0]] = reason
            else:
                loop.waiting.append(item)
        # The job may have been on dead workers only.
        self.job = self.client.scatter(loop.job, broadcast=True, hash=False)

    def compare(self, index, part):
        """Compares the proof of an item with its first drawing."""
        loop = self.loop
        if index not in self.report.crcs:
            return
        if not part.done:
            self.unproved(index, part.failed[0][1])
            return
        first, second = loop.drawn_by[index], part.worker
        crc, found = self.report.crcs[index], part.done[0][1]
        if found == crc:
            self.report.verified += 1
            return
        own = self.third_opinion(index, "%s got crc %08x and %s %08x" % (first, crc, second, found), (crc, found))
        if own is None:
            return
        words = "item %d: crc %08x, expected %08x"
        if found != own:
            self.accuse(second, words % (index, found, own))
            if crc == own:
                self.to_prove.append(index)
        if crc != own:
            self.accuse(first, words % (index, crc, own))

    def third_opinion(self, index, disagreement, crcs):
        """Returns the CRC of an item that this process draws because two workers disagree. Where it
        tells nothing, as of a function that gives other bytes each time, no worker is to blame: the
        item has failed."""
        loop = self.loop
        try:
            own = loop.job.prove(index, loop.params[index])
            if own in crcs or own == loop.job.prove(index, loop.params[index]):
                return own
            why = "and this process other ones each time: with verify=0 such results are taken unproved"
        except Exception as error:
            why = "and this process %s: %s" % (type(error).__name__, error)
        self.report.failed[index] = "%s, %s" % (disagreement, why)
        self.report.workers[loop.drawn_by.pop(index)] -= 1
        del self.report.crcs[index]
        loop.sink.forget([index])
        return None

    def unproved(self, index, why):
        """Takes a proof that failed: it is tried again, as an item is, and nobody is to blame."""
        self.failures[index] += 1
        if self.failures[index] <= self.loop.retries:
            self.to_prove.append(index)
        else:
            self.report.notes.append("%d not verified: %s" % (index, why))

    def accuse(self, worker, why):
        """Leaves a worker out from now on; what it drew is drawn again."""
        loop, report = self.loop, self.report
        if worker in report.accused:
            return
        report.accused[worker] = why
        own = sorted(index for index, by in loop.drawn_by.items() if by == worker)
        for index in own:
            del report.crcs[index], loop.drawn_by[index]
        loop.sink.forget(own)
        report.workers.pop(worker, None)
        report.redrawn += len(own)
        loop.waiting.extend((index, loop.params[index]) for index in own)
