/* SPDX-License-Identifier: GPL-3.0-or-later
 * grid.c - the points of a sweep, from texts like "pawl.stop_shift=-1.2:0:13 mm".
 *
 *   point = ((i0 * n1 + i1) * n2 + i2) ...     i_k: index on axis k, the last axis fastest
 *
 * A value of a grid is computed in the given unit, rounded to 15 decimal digits of the axis'
 * largest number, and then read like any number of a mechanism file. So the grid -1.2:0:13 mm holds
 * exactly the double of "-1.1 mm", not from + i*step with the noise of a binary 0.1.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sweep.h"
#include "reader.h"

enum { NUMBER = 64 };
static const mech_dim pure = {.kg = 0};

/* a number as written, cut from its unit */
typedef struct item {
    double typed;
    char unit[MECH_UNIT]; /* "" when none was given */
} item;

/* an axis while it is read */
typedef struct spec {
    item *item; /* numbers of a list, or both ends of a grid */
    int n;
    int count; /* of a grid, 0 for a list */
    char trailing[MECH_UNIT];
} spec;

/* ---- numbers and units ---- */

static int trim_copy(char *to, size_t room, const char *from, size_t length)
{
    while (length > 0 && (*from == ' ' || *from == '\t')) {
        from++;
        length--;
    }
    while (length > 0 && (from[length - 1] == ' ' || from[length - 1] == '\t')) {
        length--;
    }
    if (length >= room) {
        return -1;
    }
    memcpy(to, from, length);
    to[length] = '\0';
    return 0;
}

/* characters of the number at the start of s */
static size_t number_length(const char *s)
{
    size_t n = strspn(s, "+-");
    n += strspn(s + n, " \t");
    n += strspn(s + n, "0123456789.");
    if (s[n] == 'e' || s[n] == 'E') {
        size_t k = n + 1 + (s[n + 1] == '+' || s[n + 1] == '-');
        size_t digits = strspn(s + k, "0123456789");
        n = digits > 0 ? k + digits : n;
    }
    return n;
}

static stein_status read_item(item *out, const char *text, size_t length, stein_err *err)
{
    char whole[NUMBER + MECH_UNIT], number[NUMBER];
    if (trim_copy(whole, sizeof whole, text, length) != 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%.40s\" is too long for a number", text);
    }
    size_t digits = number_length(whole);
    if (trim_copy(number, sizeof number, whole, digits) != 0 ||
        trim_copy(out->unit, sizeof out->unit, whole + digits, strlen(whole + digits)) != 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%.40s\" is too long for a number", whole);
    }
    if (*number == '\0') {
        return lab__fail(err, STEIN_EINVAL, "\"%.40s\" is not a number", whole);
    }
    return mech_parse_quantity(number, pure, &out->typed, err);
}

/* number and unit as the reader of mechanism files understands them */
static stein_status quantity(double typed, const char *unit, mech_dim dim, double *value,
                             stein_err *err)
{
    char number[LAB_NUMBER], text[LAB_NUMBER + MECH_UNIT + 1];
    snprintf(text, sizeof text, "%s%s%s", lab__number(number, typed), *unit != '\0' ? " " : "",
             unit);
    return mech_parse_quantity(text, dim, value, err);
}

/* ---- reading an axis ---- */

static stein_status read_count(spec *s, const char *text, stein_err *err)
{
    text += strspn(text, " \t");
    size_t digits = strspn(text, "0123456789");
    long count = digits < 10 ? strtol(text, NULL, 10) : LAB_POINTS + 1L;
    if (digits == 0 || strchr(".eE:", text[digits] != '\0' ? text[digits] : ' ') != NULL) {
        return lab__fail(err, STEIN_EINVAL, "COUNT is \"%.40s\": expected a whole number", text);
    }
    if (count < 1 || count > LAB_POINTS) {
        return lab__fail(err, STEIN_EINVAL, "COUNT is %.20s: expected 1 to %d", text,
                         (int)LAB_POINTS);
    }
    s->count = (int)count;
    if (trim_copy(s->trailing, sizeof s->trailing, text + digits, strlen(text + digits)) != 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%.40s\" is no unit", text + digits);
    }
    return STEIN_OK;
}

static stein_status read_range(spec *s, const char *text, stein_err *err)
{
    const char *second = strchr(text, ':') + 1, *third = strchr(second, ':');
    if (third == NULL || strchr(text, ',') != NULL) {
        return lab__fail(err, STEIN_EINVAL, "expected FROM:TO:COUNT");
    }
    s->n = 2;
    stein_status status = read_item(&s->item[0], text, (size_t)(second - 1 - text), err);
    if (status == STEIN_OK) {
        status = read_item(&s->item[1], second, (size_t)(third - second), err);
    }
    return status == STEIN_OK ? read_count(s, third + 1, err) : status;
}

static stein_status read_list(spec *s, const char *text, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (; status == STEIN_OK && text != NULL; s->n++) {
        const char *comma = strchr(text, ',');
        size_t length = comma != NULL ? (size_t)(comma - text) : strlen(text);
        status = read_item(&s->item[s->n], text, length, err);
        text = comma != NULL ? comma + 1 : NULL;
    }
    return status;
}

static stein_status read_spec(spec *s, const char *text, stein_err *err)
{
    size_t room = 2;
    for (const char *c = text; *c != '\0'; c++) {
        room += *c == ',';
    }
    if (room > LAB_POINTS) {
        return lab__fail(err, STEIN_EINVAL, "more than %d values", (int)LAB_POINTS);
    }
    s->item = calloc(room, sizeof *s->item);
    if (s->item == NULL) {
        return lab__no_memory(err);
    }
    return strchr(text, ':') != NULL ? read_range(s, text, err) : read_list(s, text, err);
}

/* the one unit of all numbers, or NULL when they have several */
static const char *common_unit(const spec *s)
{
    const char *unit = s->trailing;
    for (int i = 0; i < s->n; i++) {
        const char *own = s->item[i].unit;
        if (*own != '\0' && *unit != '\0' && strcmp(own, unit) != 0) {
            return NULL;
        }
        unit = *own != '\0' ? own : unit;
    }
    return unit;
}

/* numbers of several units become SI */
static stein_status unify(spec *s, mech_dim dim, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < s->n; i++) {
        item *it = &s->item[i];
        const char *unit = *it->unit != '\0' ? it->unit : s->trailing;
        if (*unit == '\0' && it->typed != 0.0) {
            return lab__fail(err, STEIN_EINVAL, "%g has no unit, others have different ones",
                             it->typed);
        }
        status = quantity(it->typed, unit, dim, &it->typed, err);
    }
    return status;
}

/* ---- values ---- */

/* decimal exponent of a number that is not 0 */
static int exponent(double x)
{
    char text[LAB_NUMBER];
    snprintf(text, sizeof text, "%.14e", x);
    return (int)strtol(strchr(text, 'e') + 1, NULL, 10);
}

/* x rounded to the 15th decimal digit of `scale` */
static double rounded(double x, double scale)
{
    int digits = x != 0.0 ? 14 - exponent(scale) + exponent(x) : -1;
    char text[LAB_NUMBER];
    if (digits < 0) {
        return 0.0;
    }
    snprintf(text, sizeof text, "%.*e", digits < 17 ? digits : 17, x);
    return strtod(text, NULL);
}

static double between(const spec *s, int i)
{
    double from = s->item[0].typed, to = s->item[1].typed;
    if (i == 0 || i == s->count - 1) {
        return i == 0 ? from : to;
    }
    double share = (double)i / (s->count - 1);
    return rounded(from * (1.0 - share) + to * share, fmax(fabs(from), fabs(to)));
}

static stein_status fill_values(lab__axis *a, const spec *s, const char *unit, mech_dim dim,
                                stein_err *err)
{
    stein_status status = STEIN_OK;
    a->n = s->count > 0 ? s->count : s->n;
    a->value = malloc(sizeof *a->value * ((size_t)a->n + 1));
    if (a->value == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < a->n; i++) {
        double typed = s->count > 0 ? between(s, i) : s->item[i].typed;
        status = quantity(typed, unit, dim, &a->value[i], err);
    }
    for (int i = 1; status == STEIN_OK && s->count > 0 && i < a->n; i++) {
        if (a->value[i] == a->value[i - 1]) {
            return lab__fail(err, STEIN_EINVAL, "%d values do not fit between two ends so near",
                             a->n);
        }
    }
    return status;
}

/* the axis written in one way, however it was typed */
static stein_status write_text(lab__axis *a, const spec *s, const char *unit, stein_err *err)
{
    size_t room = (size_t)(s->n + 1) * LAB_NUMBER + MECH_UNIT + 2, used = 0;
    a->text = malloc(room);
    if (a->text == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < s->n; i++) {
        char number[LAB_NUMBER];
        used += (size_t)snprintf(a->text + used, room - used, "%s%s",
                                 i == 0         ? ""
                                 : s->count > 0 ? ":"
                                                : ",",
                                 lab__number(number, s->item[i].typed));
    }
    if (s->count > 0) {
        used += (size_t)snprintf(a->text + used, room - used, ":%d", s->count);
    }
    snprintf(a->text + used, room - used, "%s%s", *unit != '\0' ? " " : "", unit);
    return STEIN_OK;
}

static stein_status finish_axis(lab__axis *a, spec *s, stein_err *err)
{
    mech_dim dim = pure, shown;
    stein_status status = STEIN_OK;
    const char *unit = common_unit(s);
    mech_parse_unit(a->unit, &dim, NULL);
    if (unit == NULL) {
        status = unify(s, dim, err);
        unit = "";
    }
    if (status == STEIN_OK && s->count > 0 && s->item[0].typed == s->item[1].typed &&
        s->count > 1) {
        status = lab__fail(err, STEIN_EINVAL, "%d values from an end to the same end", s->count);
    }
    if (status == STEIN_OK && s->count == 1 && s->item[0].typed != s->item[1].typed) {
        status = lab__fail(err, STEIN_EINVAL, "1 value cannot be at both ends");
    }
    if (status == STEIN_OK) {
        status = fill_values(a, s, unit, dim, err);
    }
    if (status == STEIN_OK) {
        status = write_text(a, s, unit, err);
    }
    int plain = *unit == '\0' || mech_parse_unit(unit, &shown, &a->factor) != 0;
    snprintf(a->shown, sizeof a->shown, "%s", plain ? a->unit : unit);
    a->factor = plain ? 1.0 : a->factor;
    return status;
}

/* ---- the grid ---- */

stein_status lab__grid_new(lab_grid **grid, stein_err *err)
{
    *grid = calloc(1, sizeof **grid);
    if (*grid == NULL) {
        return lab__no_memory(err);
    }
    (*grid)->n = 1;
    return STEIN_OK;
}

stein_status lab__grid_add(lab_grid *grid, const char *name, const char *unit, const char *values,
                           stein_err *err)
{
    stein_err inner = {STEIN_OK, ""};
    lab__axis *axis = realloc(grid->axis, sizeof *axis * (size_t)(grid->naxis + 1));
    if (axis == NULL) {
        return lab__no_memory(err);
    }
    grid->axis = axis;
    lab__axis *a = &axis[grid->naxis++];
    *a = (lab__axis){.name = lab__text("%s", name)};
    snprintf(a->unit, sizeof a->unit, "%s", unit);
    spec s = {NULL, 0, 0, ""};
    stein_status status = a->name != NULL ? read_spec(&s, values, &inner) : STEIN_ENOMEM;
    if (status == STEIN_OK) {
        status = finish_axis(a, &s, &inner);
    }
    free(s.item);
    if (status == STEIN_OK && a->n > LAB_POINTS / grid->n) {
        status = lab__fail(&inner, STEIN_EINVAL, "more than %d points in all", (int)LAB_POINTS);
    }
    if (status == STEIN_OK) {
        grid->n *= a->n;
        return STEIN_OK;
    }
    return lab__fail(err, status == STEIN_ENOMEM ? status : STEIN_EINVAL, "vary %s=%.60s: %s", name,
                     values, inner.msg);
}

static stein_status add_vary(lab_grid *grid, const stein_model *model, const char *vary,
                             stein_err *err)
{
    size_t length = strcspn(vary, "=");
    char name[MECH_PATH];
    if (vary[length] != '=' || length == 0 || length >= sizeof name) {
        return lab__fail(err, STEIN_EINVAL,
                         "vary %.60s: expected NAME=FROM:TO:COUNT or "
                         "NAME=VALUE,VALUE...",
                         vary);
    }
    memcpy(name, vary, length);
    name[length] = '\0';
    for (int i = 0; i < grid->naxis; i++) {
        if (strcmp(grid->axis[i].name, name) == 0) {
            return lab__fail(err, STEIN_EINVAL, "vary %s: it is varied twice", name);
        }
    }
    int i = stein_find_param(model, name);
    if (i >= 0) {
        return lab__grid_add(grid, name, model->params[i].unit, vary + length + 1, err);
    }
    mech__nearest near = {name, NULL, 0};
    for (int k = 0; k < model->np; k++) {
        mech__offer(&near, model->params[k].name);
    }
    return lab__fail(err, STEIN_ENAME, "vary %.60s: there is no parameter of that name%s%s%s", name,
                     near.best != NULL ? ", did you mean \"" : "",
                     near.best != NULL ? near.best : "", near.best != NULL ? "\"?" : "");
}

stein_status lab_grid_create(lab_grid **out, const stein_model *model, const char *const *vary,
                             int nvary, stein_err *err)
{
    lab_grid *grid = NULL;
    stein_status status = lab__grid_new(&grid, err);
    for (int i = 0; status == STEIN_OK && i < nvary; i++) {
        status = add_vary(grid, model, vary[i], err);
    }
    if (status != STEIN_OK) {
        lab_grid_destroy(grid);
        return status;
    }
    *out = grid;
    return STEIN_OK;
}

void lab_grid_destroy(lab_grid *grid)
{
    for (int i = 0; grid != NULL && i < grid->naxis; i++) {
        free(grid->axis[i].name);
        free(grid->axis[i].text);
        free(grid->axis[i].value);
    }
    if (grid != NULL) {
        free(grid->axis);
        free(grid);
    }
}

int lab_grid_points(const lab_grid *grid)
{
    return grid->n;
}

double lab_grid_value(const lab_grid *grid, int point, int axis)
{
    for (int i = grid->naxis - 1; i > axis; i--) {
        point /= grid->axis[i].n;
    }
    return grid->axis[axis].value[point % grid->axis[axis].n];
}
