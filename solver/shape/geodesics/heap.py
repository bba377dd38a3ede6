"""Heap with decrease-key, as arrays for compiled loops.

Nodes have four children, which lie next to one another in memory, as do their keys: fast marching
takes a fifth less time than with two children, and another fifth less than with keys looked up by
item.
"""

from solver.arrays import FloatArray, IndexArray, IntArray
from solver.kernel import inlined


@inlined
def push(
    items: IndexArray, keys: FloatArray, places: IntArray, size: int, item: int, key: float
) -> int:
    """Insert an item, or decrease its key.

    Parameters
    ----------
    items, keys
        (V,) items and their keys, of which the first `size` are the heap.
    places
        (V,) position of each item in the heap, -1 for items outside.
    size
        Number of items in the heap.
    item, key
        The item, and its key, not greater than the one it has.

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
        parent = (place - 1) >> 2
        if keys[parent] <= key:
            break
        items[place], keys[place] = items[parent], keys[parent]
        places[items[place]] = place
        place = parent
    items[place], keys[place] = item, key
    places[item] = place
    return size


@inlined
def pop(items: IndexArray, keys: FloatArray, places: IntArray, size: int) -> int:
    """Remove the first item, that of least key; return the new size. Parameters as in `push`."""
    places[items[0]] = -1
    size -= 1
    if size > 0:
        last, key, place = items[size], keys[size], 0
        while True:
            child = 4 * place + 1
            if child >= size:
                break
            least = keys[child]
            for other in range(child + 1, min(child + 4, size)):
                if keys[other] < least:
                    child, least = other, keys[other]
            if least >= key:
                break
            items[place], keys[place] = items[child], least
            places[items[place]] = place
            place = child
        items[place], keys[place] = last, key
        places[last] = place
    return size
