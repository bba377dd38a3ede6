"""Binary heap with decrease-key, as arrays for compiled loops."""

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined


@inlined
def push(heap: IntArray, places: IntArray, keys: FloatArray, size: int, item: int) -> int:
    """Insert an item, or restore the heap after its key has decreased.

    Parameters
    ----------
    heap
        (V,) items, of which the first `size` are the heap.
    places
        (V,) position of each item in the heap, -1 for items outside.
    keys
        (V,) of the items.
    size
        Number of items in the heap.
    item
        The item, with its key already in `keys`.

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
    """Remove the item of least key; return it and the new size. Parameters as in `push`."""
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
