"""Small systems of equations inside compiled loops."""

from .jit import jit, like


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
def invert_symmetric(matrix, size, least):
    """Replace a symmetric positive matrix by its inverse, by Gauss-Jordan elimination.

    Parameters
    ----------
    matrix : ndarray, shape (>= size, >= size)
    size : int
    least : float
        The matrix counts as ill-conditioned when a pivot falls below so much of the diagonal.

    Returns
    -------
    bool
        False when it is ill-conditioned; `matrix` is then of no use.
    """
    largest = 0.0
    for k in range(size):
        largest = max(largest, matrix[k, k])
    for k in range(size):
        if not matrix[k, k] > least * largest:
            return False
        inverse = 1.0 / matrix[k, k]
        matrix[k, k] = 1.0
        for j in range(size):
            matrix[k, j] *= inverse
        for i in range(size):
            if i != k:
                factor = matrix[i, k]
                matrix[i, k] = 0.0
                for j in range(size):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@jit
def cofactors(xx, xy, xz, yy, yz, zz, dim):
    """Return the cofactors of a symmetric matrix of `dim` rows, in the order of its elements, and its determinant.

    The inverse is cofactors over determinant; those beyond `dim` are zero.
    """
    none = like(0.0, xx)
    if dim == 1:
        return like(1.0, xx), none, none, none, none, none, xx
    if dim == 2:
        return yy, -xy, none, xx, none, none, xx * yy - xy * xy
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    return a, b, c, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy, xx * a + xy * b + xz * c
