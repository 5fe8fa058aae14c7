/* SPDX-License-Identifier: GPL-3.0-or-later
 * label.c - names beside their elements: the nearest of a few places where no other name and no
 * joint is.
 */
#include <math.h>
#include <string.h>

#include "draw.h"

static const double letter = 9.0, line = 19.0, away = 9.0; /* [px] */

static int overlaps(const draw__label *a, const draw__label *b)
{
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

static int is_free(const draw__labels *all, const draw__label *box)
{
    if (box->x0 < 2.0 || box->y0 < 2.0 || box->x1 > all->width - 2.0 ||
        box->y1 > all->height - 2.0) {
        return 0;
    }
    for (int i = 0; i < all->n; i++) {
        if (overlaps(&all->taken[i], box)) {
            return 0;
        }
    }
    return 1;
}

static void take(draw__labels *all, draw__label box)
{
    if (all->n < DRAW_LABELS) {
        all->taken[all->n++] = box;
    }
}

void draw__keep_off(draw__labels *all, double x, double y, double half)
{
    take(all, (draw__label){x - half, y - half, x + half, y + half});
}

/* box of a text of so many letters, the k-th of eight directions, so far away */
static draw__label box_at(double x, double y, double wide, int k, double far)
{
    static const double dx[] = {1, 1, -1, -1, 1, -1, 0, 0}, dy[] = {-1, 1, -1, 1, 0, 0, -1, 1};
    double cx = x + dx[k] * (far + 0.5 * wide), cy = y + dy[k] * (far + 0.5 * line);
    return (draw__label){cx - 0.5 * wide, cy - 0.5 * line, cx + 0.5 * wide, cy + 0.5 * line};
}

static void put_text(FILE *f, const draw__label *box, const char *kind, const char *name)
{
    fprintf(f, "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\">", kind, 0.5 * (box->x0 + box->x1),
            box->y1 - 5.0);
    for (const char *c = name; *c != '\0'; c++) {
        if (*c == '<' || *c == '&') {
            fprintf(f, "&#%d;", *c);
        } else {
            putc(*c, f);
        }
    }
    fputs("</text>\n", f);
}

void draw__name(draw__labels *all, FILE *f, double x, double y, const char *kind, const char *name)
{
    double wide = letter * (double)strlen(name);
    draw__label box = box_at(x, y, wide, 0, away);
    double far = away;
    int found = 0;
    for (int ring = 0; ring < 8 && !found; ring++) {
        for (int k = 0; k < 8 && !found; k++) {
            draw__label tried = box_at(x, y, wide, k, away + 14.0 * ring);
            if (is_free(all, &tried)) {
                box = tried;
                far = away + 14.0 * ring;
                found = 1;
            }
        }
    }
    take(all, box);
    if (far > away) {
        double cx = fmin(fmax(x, box.x0), box.x1), cy = fmin(fmax(y, box.y0), box.y1);
        fprintf(f, "<path class=\"leader\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", x, y, cx, cy);
    }
    put_text(f, &box, kind, name);
}
