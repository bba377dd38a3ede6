"""A binary heap of vertices, the nearest on top, in which a vertex can move up."""

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined


@inlined
def lift(heap: IntArray, places: IntArray, keys: FloatArray, size: int, item: int) -> int:
    """Put an item in, or move it to where its lower key belongs.

    Parameters
    ----------
    heap
        (V,) items; the first `size` count.
    places
        (V,) index in the heap of each item, -1 for those that are not in it.
    keys
        (V,) of the items.
    size
        Number of items in the heap.
    item
        Whose key is new.

    Returns
    -------
    int
        The new size.
    """
    place = places[item]
    if place < 0:
        place = size
        size += 1
    while place > 0:
        parent = (place - 1) // 2
        if keys[heap[parent]] <= keys[item]:
            break
        heap[place] = heap[parent]
        places[heap[place]] = place
        place = parent
    heap[place] = item
    places[item] = place
    return size


@inlined
def pop(heap: IntArray, places: IntArray, keys: FloatArray, size: int) -> tuple[int, int]:
    """Take out the item of least key; the item and the new size. Parameters as in `lift`."""
    least = heap[0]
    places[least] = -1
    size -= 1
    if size > 0:
        last, place = heap[size], 0
        while True:
            child = 2 * place + 1
            if child >= size:
                break
            if child + 1 < size and keys[heap[child + 1]] < keys[heap[child]]:
                child += 1
            if keys[heap[child]] >= keys[last]:
                break
            heap[place] = heap[child]
            places[heap[place]] = place
            place = child
        heap[place] = last
        places[last] = place
    return least, size
