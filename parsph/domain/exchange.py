"""What moves between slabs: migrants, copies at periodic ends and halos, and values of fixed ghosts."""

import numpy as np

COUNTS, HALO, MIGRANTS, VALUES = 1, 2, 3, 4


class Exchange:
    """Messages with the left and the right neighbour.

    A halo is a contiguous slice of rows, sent as it stands and received where it belongs. Its cell counts travel ahead,
    while the own rows are being ordered.

    Parameters
    ----------
    communicator : Communicator
    particles : Particles
    ring : bool
        Whether the slabs are a ring, since x is periodic: the first rank is then the right neighbour of the last one, but for
        halos, in whose place copies stand at the ends.

    Attributes
    ----------
    across : int or None
        The rank at the other end of the ring, on its first and its last rank.
    """

    def __init__(self, communicator, particles, ring=False):
        self.communicator, self.particles = communicator, particles
        rank, size = communicator.rank, communicator.size
        self.left = rank - 1 if rank > 0 else None
        self.right = rank + 1 if rank + 1 < size else None
        self.across = {0: size - 1, size - 1: 0}.get(rank) if ring and size > 1 else None
        self._requests = []
        self._empty = np.empty((0, particles.shared.shape[1] + particles.private.shape[1] + 1))
        self.messages, self.bytes = 0, 0

    def _send(self, array, rank, tag):
        self.messages += 1
        self.bytes += array.nbytes
        return self.communicator.comm.Isend(array, rank, tag)

    def migrate(self, to_left, to_right):
        """Send the particles in the given rows to the neighbours, and append those that they send.

        A message is a table of (shared row, private row, tag), as it is short and its length unknown to the receiver.
        """
        left = self.across if self.left is None else self.left
        right = self.across if self.right is None else self.right
        self._trade([(rank, rows) for rank, rows in ((left, to_left), (right, to_right)) if rank is not None])

    def trade_copies(self, first):
        """Send the rows from `first` on, copies at an end of a periodic x, to the rank at the other end, where they stand, and
        put those that it sends in their place; ranks between have none.
        """
        if self.across is not None:
            rows = np.arange(first, self.particles.last)
            self.particles.last = first
            self._trade([(self.across, rows)])

    def _trade(self, shipments):
        mpi = self.communicator.mpi
        parcels = [(rank, self._parcel(rows)) for rank, rows in shipments]
        requests = [self._send(parcel, rank, MIGRANTS) for rank, parcel in parcels]
        for rank, _ in shipments:
            status = mpi.Status()
            message = self.communicator.comm.Mprobe(rank, MIGRANTS, status)
            parcel = np.empty((status.Get_count(mpi.DOUBLE) // self._empty.shape[1], self._empty.shape[1]))
            message.Recv(parcel)
            if len(parcel):
                self._unpack(parcel)
        mpi.Request.Waitall(requests)

    def _parcel(self, rows):
        if not len(rows):
            return self._empty
        p = self.particles
        return np.concatenate([p.shared[rows], p.private[rows], p.tags[rows].view(np.float64)[:, None]], axis=1)

    def _unpack(self, parcel):
        p, width = self.particles, self.particles.shared.shape[1]
        rows = slice(p.last, p.last + len(parcel))
        p.reserve(rows.stop)
        p.shared[rows] = parcel[:, :width]
        p.private[rows] = parcel[:, width:-1]
        p.tags[rows] = np.ascontiguousarray(parcel[:, -1]).view(np.int64)
        p.last = rows.stop

    def edge_counts(self, counts, stride):
        """Return the counts per cell of the neighbours' edge columns, left and right, each of shape (stride,)."""
        before, after = np.zeros(stride, np.int64), np.zeros(stride, np.int64)
        requests, edges = [], []
        for rank, halo, edge in ((self.left, before, counts[:stride]), (self.right, after, counts[-stride:])):
            if rank is not None:
                edges.append(edge.copy())
                requests.append(self.communicator.comm.Irecv(halo, rank, COUNTS))
                requests.append(self._send(edges[-1], rank, COUNTS))
        if requests:
            self.communicator.mpi.Request.Waitall(requests)
        return before, after

    def start_halo(self, starts, stride, rows):
        """Post the exchange of the edge columns of an array; `starts` are the local cell starts, halo columns included."""
        comm = getattr(self.communicator, "comm", None)
        if self.left is not None:
            self._requests.append(comm.Irecv(rows[: starts[stride]], self.left, HALO))
            self._requests.append(self._send(rows[starts[stride] : starts[2 * stride]], self.left, HALO))
        if self.right is not None:
            end = len(starts) - 1
            self._requests.append(comm.Irecv(rows[starts[end - stride] : starts[end]], self.right, HALO))
            self._requests.append(self._send(rows[starts[end - 2 * stride] : starts[end - stride]], self.right, HALO))

    def finish_halo(self):
        """Wait for the halos."""
        if self._requests:
            self.communicator.mpi.Request.Waitall(self._requests)
            self._requests = []

    def swap_values(self, values, sent, received):
        """Send the rows of a table that all ranks have to those that need them, and fill in those of others.

        Parameters
        ----------
        values : ndarray, shape (n, k)
        sent, received : dict of int to ndarray of int
            Rows by rank; what one sends is what the other receives.
        """
        requests, parcels = [], []
        for rank, rows in received.items():
            parcels.append((rows, np.empty((len(rows), values.shape[1]))))
            requests.append(self.communicator.comm.Irecv(parcels[-1][1], rank, VALUES))
        outgoing = [values[rows] for rows in sent.values()]
        for rank, parcel in zip(sent, outgoing, strict=True):
            requests.append(self._send(parcel, rank, VALUES))
        if requests:
            self.communicator.mpi.Request.Waitall(requests)
        for rows, parcel in parcels:
            values[rows] = parcel
