"""Small systems of equations inside compiled loops."""

from .jit import jit


@jit
def solve_symmetric(matrix, vector, size, least):
    """Solve ``matrix x = vector`` for a symmetric positive matrix by elimination; both are overwritten, `vector` by x.

    Parameters
    ----------
    matrix : ndarray, shape (>= size, >= size)
    vector : ndarray, shape (>= size,)
    size : int
    least : float
        The matrix counts as ill-conditioned when a pivot falls below so much of its diagonal entry.

    Returns
    -------
    bool
        False when it is ill-conditioned; `vector` is then of no use.
    """
    for k in range(size):
        before = matrix[k, k]
        for j in range(k):  # what the rows above have left of the diagonal entry
            before += matrix[j, k] * matrix[k, j]
        if not matrix[k, k] > least * before:
            return False
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, size):
                matrix[i, j] -= factor * matrix[k, j]
            vector[i] -= factor * vector[k]
            matrix[i, k] = factor
    for k in range(size - 1, -1, -1):
        for j in range(k + 1, size):
            vector[k] -= matrix[k, j] * vector[j]
        vector[k] /= matrix[k, k]
    return True


@jit
def invert_symmetric(matrix, size, least, inverse, work, vector):
    """Set `inverse` to that of a symmetric positive `matrix`, which stays as it is; `work` and `vector` are overwritten.

    Parameters
    ----------
    matrix, inverse, work : ndarray, shape (>= size, >= size)
    vector : ndarray, shape (>= size,)
    size, least
        As `solve_symmetric`.

    Returns
    -------
    bool
        False when it is ill-conditioned; `inverse` is then of no use.
    """
    for column in range(size):
        work[:size, :size] = matrix[:size, :size]
        vector[:size] = 0.0
        vector[column] = 1.0
        if not solve_symmetric(work, vector, size, least):
            return False
        inverse[:size, column] = vector[:size]
    return True
