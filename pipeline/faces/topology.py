"""Which of MediaPipe's 478 points are lips, eyes, brows and oval.

Left and right are those of the picture.
"""

import numpy as np

EYE_CORNERS = (33, 263)  # the outer corners: their distance is the inter-ocular distance (IOD)
MOUTH_CORNERS = (61, 291)  # the picture's left and right

# Closed contours, in order.
LIPS_OUTER = np.array([61, 146, 91, 181, 84, 17, 314, 405, 321, 375,
                       291, 409, 270, 269, 267, 0, 37, 39, 40, 185])  # fmt: skip
LIPS_INNER = np.array([78, 95, 88, 178, 87, 14, 317, 402, 318, 324,
                       308, 415, 310, 311, 312, 13, 82, 81, 80, 191])  # fmt: skip
FACE_OVAL = np.array([10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288,
                      397, 365, 379, 378, 400, 377, 152, 148, 176, 149, 150, 136,
                      172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109])  # fmt: skip

# Four rings of 20 points, from the vermilion border to the mouth opening.
LIPS = np.array([
    61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291, 185, 40, 39, 37, 0, 267, 269, 270, 409,
    78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308, 191, 80, 81, 82, 13, 312, 311, 310, 415,
    76, 77, 90, 180, 85, 16, 315, 404, 320, 307, 306, 184, 74, 73, 72, 11, 302, 303, 304, 408,
    62, 96, 89, 179, 86, 15, 316, 403, 319, 325, 292, 183, 42, 41, 38, 12, 268, 271, 272, 407,
])  # fmt: skip

# The eye at the left of an upright picture: lid contour, two rings around it, iris.
EYE_CONTOUR = np.array([33, 7, 163, 144, 145, 153, 154, 155, 133,
                        173, 157, 158, 159, 160, 161, 246])  # fmt: skip
EYE = np.concatenate([EYE_CONTOUR, [
    130, 25, 110, 24, 23, 22, 26, 112, 243, 247, 30, 29, 27, 28, 56, 190,
    226, 31, 228, 229, 230, 231, 232, 233, 244, 113, 225, 224, 223, 222, 221, 189,
    468, 469, 470, 471, 472,
]])  # fmt: skip

# The eye at the right: EYE, mirrored point by point.
RIGHT_EYE = np.array([
    263, 249, 390, 373, 374, 380, 381, 382, 362, 398, 384, 385, 386, 387, 388, 466,
    359, 255, 339, 254, 253, 252, 256, 341, 463, 467, 260, 259, 257, 258, 286, 414,
    446, 261, 448, 449, 450, 451, 452, 453, 464, 342, 445, 444, 443, 442, 441, 413,
    473, 476, 475, 474, 477,
])  # fmt: skip

# The lower edges of both brows, each from its outer to its inner end.
BROW = np.array([46, 53, 52, 65, 55])
RIGHT_BROW = np.array([276, 283, 282, 295, 285])
