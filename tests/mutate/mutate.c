/* SPDX-License-Identifier: GPL-3.0-or-later
 * mutate.c - a source file with one small mistake in it: what `make mutate` lets the tests find.
 *
 *   mutate list SEED N FILE...     N mutants drawn from all of the files (N = 0: all), one a line:
 *                                  FILE <tab> NUMBER <tab> LINE <tab> CHANGE <tab> text of the line
 *   mutate apply FILE NUMBER       the file with that mistake, to standard output
 *
 * Mistakes:
 *
 *   arithmetic   + -  * /  % -> *  << >>  & |  and the same with =; a sign left out
 *   comparison   its neighbour (< to <=) and its opposite (< to >=); == to !=
 *   logic        && ||; a ! left out
 *   condition    of if and while turned round
 *   number       of int one more, of double 1.1 times as large, 0.0 to 1.0
 *   statement    an assignment, a call, break or continue left out
 *
 * Not touched: comments, texts, preprocessor lines, enums and sizes of arrays (capacities: more is
 * no mistake), ++ and -- (a loop that never ends is found by any test). Operators are told from
 * signs and stars by the blanks that clang-format puts around them.
 */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_CHANGE = 256 };

/* a file and the mutant that is wanted of it */
typedef struct source {
    const char *name;
    char *text;
    size_t size;
    unsigned char *code; /* [size] 1: no comment, text, preprocessor line or enum */
} source;

/* text[at, at + length) becomes `with` */
typedef struct change {
    size_t at, length;
    char with[MAX_CHANGE];
} change;

typedef void change_fn(void *ctx, const source *s, const change *c);

static void *need(void *block)
{
    if (block == NULL) {
        fprintf(stderr, "mutate: out of memory\n");
        exit(1);
    }
    return block;
}

static void read_source(source *s, const char *name)
{
    FILE *f = fopen(name, "rb");
    if (f == NULL || fseek(f, 0, SEEK_END) != 0) {
        fprintf(stderr, "mutate: %s cannot be read\n", name);
        exit(1);
    }
    long size = ftell(f);
    rewind(f);
    s->name = name;
    s->size = (size_t)size;
    s->text = need(calloc(s->size + 2, 1));
    s->code = need(calloc(s->size + 2, 1));
    if (fread(s->text, 1, s->size, f) != s->size) {
        fprintf(stderr, "mutate: %s cannot be read\n", name);
        exit(1);
    }
    fclose(f);
}

static void free_source(source *s)
{
    free(s->text);
    free(s->code);
}

static int is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

/* does the word stand here, from a beginning to an end? */
static int word_at(const source *s, size_t i, const char *word)
{
    size_t n = strlen(word);
    return (i == 0 || !is_word(s->text[i - 1])) && strncmp(s->text + i, word, n) == 0 &&
           !is_word(s->text[i + n]);
}

/* behind what is no code and begins at i, or i when code is there */
static size_t behind_no_code(const source *s, size_t i)
{
    const char *t = s->text;
    if (strncmp(t + i, "/*", 2) == 0) {
        const char *end = strstr(t + i + 2, "*/");
        return end != NULL ? (size_t)(end - t) + 2 : s->size;
    }
    if (strncmp(t + i, "//", 2) == 0) {
        return i + strcspn(t + i, "\n");
    }
    if (t[i] == '"' || t[i] == '\'') {
        size_t end = i + 1;
        while (end < s->size && t[end] != t[i]) {
            end += t[end] == '\\' ? 2 : 1;
        }
        return end + 1;
    }
    if (t[i] == '#') {
        size_t end = i;
        while (end < s->size && (t[end] != '\n' || t[end - 1] == '\\')) {
            end++;
        }
        return end;
    }
    return word_at(s, i, "enum") ? i + strcspn(t + i, ";") : i;
}

static void mark_code(source *s)
{
    for (size_t i = 0; i < s->size;) {
        size_t end = behind_no_code(s, i);
        if (end == i) {
            s->code[i++] = 1;
        } else {
            i = end < s->size ? end : s->size;
        }
    }
}

/* ---- the mistakes ---- */

/* @return length of the operator with blanks around it at i, and what may stand in its place */
static size_t operator_at(const source *s, size_t i, const char *const **others)
{
    static const char *const swaps[][4] = {
        {"+", "-"},        {"-", "+"},       {"*", "/"},        {"/", "*"},       {"%", "*"},
        {"<<", ">>"},      {">>", "<<"},     {"&", "|"},        {"|", "&"},       {"+=", "-="},
        {"-=", "+="},      {"*=", "/="},     {"/=", "*="},      {"&=", "|="},     {"|=", "&="},
        {"<", "<=", ">="}, {"<=", "<", ">"}, {">", ">=", "<="}, {">=", ">", "<"}, {"==", "!="},
        {"!=", "=="},      {"&&", "||"},     {"||", "&&"},
    };
    if (i == 0 || s->text[i - 1] != ' ') {
        return 0;
    }
    size_t n = strcspn(s->text + i, " \n");
    for (size_t k = 0; k < sizeof swaps / sizeof *swaps; k++) {
        if (strlen(swaps[k][0]) == n && strncmp(s->text + i, swaps[k][0], n) == 0) {
            *others = swaps[k] + 1;
            return n;
        }
    }
    return 0;
}

static int is_sign(const source *s, size_t i)
{
    size_t before = i;
    while (before > 0 && s->text[before - 1] == ' ') {
        before--;
    }
    int opens = before > 0 && strchr("(,=?:[{*", s->text[before - 1]) != NULL;
    int returned = before >= 6 && strncmp(s->text + before - 6, "return", 6) == 0;
    return s->text[i] == '-' && (opens || returned) &&
           (is_word(s->text[i + 1]) || s->text[i + 1] == '(');
}

/* length of a number that begins at i */
static size_t number_at(const source *s, size_t i)
{
    if (!isdigit((unsigned char)s->text[i]) ||
        (i > 0 && (is_word(s->text[i - 1]) || s->text[i - 1] == '.'))) {
        return 0;
    }
    size_t end = i;
    while (is_word(s->text[end]) || s->text[end] == '.' ||
           ((s->text[end] == '-' || s->text[end] == '+') &&
            strchr("eE", s->text[end - 1]) != NULL && s->text[i + 1] != 'x')) {
        end++;
    }
    return end - i;
}

/* is the number at i the capacity of an array that is declared here? */
static int is_capacity(const source *s, size_t i, size_t n)
{
    size_t begin = i;
    while (begin > 0 && s->text[begin - 1] != '\n') {
        begin--;
    }
    const char *line = s->text + begin + strspn(s->text + begin, " ");
    size_t type = strspn(line, "abcdefghijklmnopqrstuvwxyz_0123456789");
    return i > 0 && s->text[i - 1] == '[' && s->text[i + n] == ']' && line[type] == ' ' &&
           (is_word(line[type + 1]) || line[type + 1] == '*') &&
           memchr(line, '=', i - (size_t)(line - s->text)) == NULL &&
           !word_at(s, (size_t)(line - s->text), "return");
}

static void change_number(const source *s, size_t i, size_t n, change *c)
{
    char number[64];
    snprintf(number, sizeof number, "%.*s", (int)n, s->text + i);
    char *end;
    unsigned long long whole = strtoull(number, &end, 0);
    c->at = i;
    c->length = n;
    if (strpbrk(number, ".eE") != NULL && strncmp(number, "0x", 2) != 0) {
        snprintf(c->with, sizeof c->with, strtod(number, NULL) == 0.0 ? "1.0" : "(1.1 * %s)",
                 number);
    } else {
        snprintf(c->with, sizeof c->with, "%llu%s", whole + 1, end);
    }
}

/* the bracket that closes the one at i; 0: none in the code */
static size_t closing(const source *s, size_t i)
{
    int depth = 0;
    for (size_t k = i; k < s->size; k++) {
        if (s->code[k]) {
            depth += s->text[k] == '(' ? 1 : s->text[k] == ')' ? -1 : 0;
            if (depth == 0) {
                return k;
            }
        }
    }
    return 0;
}

/* length of the statement at i that may be left out: no declaration, no return */
static size_t statement_at(const source *s, size_t i)
{
    const char *t = s->text;
    size_t before = i;
    while (before > 0 && (isspace((unsigned char)t[before - 1]) || !s->code[before - 1])) {
        before--;
    }
    int choice = before > 1 && t[before - 1] == ':' && t[before - 2] == ' '; // of ? :
    if (before == 0 || strchr("{};:", t[before - 1]) == NULL || before == i || choice ||
        !(isalpha((unsigned char)t[i]) || t[i] == '*')) {
        return 0;
    }
    size_t first =
        strspn(t + i, "*abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789");
    const char *next = t + i + first;
    int single = word_at(s, i, "break") || word_at(s, i, "continue");
    int declares = next[0] == ' ' && (is_word(next[1]) || next[1] == '*');
    if (word_at(s, i, "return") || word_at(s, i, "case") || word_at(s, i, "default") ||
        word_at(s, i, "else") || word_at(s, i, "for") || word_at(s, i, "if") ||
        word_at(s, i, "while") || word_at(s, i, "do") || word_at(s, i, "switch") || declares) {
        return 0;
    }
    size_t n = strcspn(t + i, ";{}");
    int does = memchr(t + i, '=', n) != NULL || memchr(t + i, '(', n) != NULL;
    return t[i + n] == ';' && (single || does) ? n : 0;
}

static void replace(const source *s, size_t at, size_t n, const char *with, change_fn *each,
                    void *ctx)
{
    change c = {.at = at, .length = n};
    snprintf(c.with, sizeof c.with, "%s", with);
    each(ctx, s, &c);
}

/* every mistake that begins at i */
static void changes_at(const source *s, size_t i, change_fn *each, void *ctx)
{
    const char *const *others;
    change c;
    size_t n = operator_at(s, i, &others);
    for (int k = 0; n > 0 && k < 3 && others[k] != NULL; k++) {
        replace(s, i, n, others[k], each, ctx);
    }
    if (is_sign(s, i) || (s->text[i] == '!' && s->text[i + 1] != '=')) {
        replace(s, i, 1, "", each, ctx);
    }
    n = number_at(s, i);
    if (n > 0 && !is_capacity(s, i, n)) {
        change_number(s, i, n, &c);
        each(ctx, s, &c);
    }
    if (word_at(s, i, "if") || word_at(s, i, "while")) {
        size_t open = i + strcspn(s->text + i, "("), close = closing(s, open);
        c = (change){.at = open, .length = close + 1 - open};
        int fits = snprintf(c.with, sizeof c.with, "(!%.*s)", (int)c.length, s->text + open);
        if (close > 0 && fits < (int)sizeof c.with) {
            each(ctx, s, &c);
        }
    }
    n = statement_at(s, i);
    if (n > 0) {
        replace(s, i, n, "", each, ctx);
    }
}

static void all_changes(source *s, change_fn *each, void *ctx)
{
    mark_code(s);
    for (size_t i = 0; i < s->size; i++) {
        if (s->code[i]) {
            changes_at(s, i, each, ctx);
        }
    }
}

/* ---- list ---- */

static void put_flat(const char *text, size_t n)
{
    int blank = 0;
    for (size_t i = 0; i < n; i++) {
        int space = isspace((unsigned char)text[i]);
        if (!space || !blank) {
            putchar(space ? ' ' : text[i]);
        }
        blank = space;
    }
}

static void put_change(const source *s, const change *c, int number)
{
    size_t begin = c->at, line = 1;
    for (size_t i = 0; i < c->at; i++) {
        line += s->text[i] == '\n';
    }
    while (begin > 0 && s->text[begin - 1] != '\n') {
        begin--;
    }
    size_t indent = strspn(s->text + begin, " ");
    printf("%s\t%d\t%zu\t", s->name, number, line);
    put_flat(s->text + c->at, c->length);
    printf(" -> ");
    put_flat(c->with, strlen(c->with));
    printf("\t%zu: ", c->at - begin - indent + 1);
    put_flat(s->text + begin + indent, strcspn(s->text + begin + indent, "\n"));
    putchar('\n');
}

/* of all mutants, in order, those whose bit is set */
typedef struct listing {
    const unsigned char *picked; /* NULL: count only */
    int n, of_file;
} listing;

static void list_one(void *ctx, const source *s, const change *c)
{
    listing *l = ctx;
    if (l->picked != NULL && l->picked[l->n]) {
        put_change(s, c, l->of_file);
    }
    l->n++;
    l->of_file++;
}

static void list_files(listing *l, char **files, int n)
{
    l->n = 0;
    for (int i = 0; i < n; i++) {
        source s;
        read_source(&s, files[i]);
        l->of_file = 0;
        all_changes(&s, list_one, l);
        free_source(&s);
    }
}

static unsigned long long next_random(unsigned long long *state)
{
    *state += 0x9e3779b97f4a7c15u; // splitmix64, Steele et al. 2014
    unsigned long long z = *state;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static int list(unsigned long long seed, int wanted, char **files, int n)
{
    listing l = {NULL, 0, 0};
    list_files(&l, files, n);
    int all = l.n;
    unsigned char *picked = need(calloc((size_t)all + 1, 1));
    if (wanted <= 0 || wanted >= all) {
        memset(picked, 1, (size_t)all);
    } else {
        for (int have = 0; have < wanted;) {
            int i = (int)(next_random(&seed) % (unsigned long long)all);
            have += !picked[i];
            picked[i] = 1;
        }
    }
    l.picked = picked;
    list_files(&l, files, n);
    fprintf(stderr, "%d mutants of %d\n", wanted > 0 && wanted < all ? wanted : all, all);
    free(picked);
    return 0;
}

/* ---- apply ---- */

typedef struct wish {
    int left, found;
    change change;
} wish;

static void find_one(void *ctx, const source *s, const change *c)
{
    wish *w = ctx;
    (void)s;
    if (w->left-- == 0) {
        w->found = 1;
        w->change = *c;
    }
}

static int apply(const char *file, int number)
{
    source s;
    wish w = {.left = number};
    read_source(&s, file);
    all_changes(&s, find_one, &w);
    if (!w.found) {
        fprintf(stderr, "mutate: %s has no mutant %d\n", file, number);
        return 1;
    }
    size_t behind = w.change.at + w.change.length;
    fwrite(s.text, 1, w.change.at, stdout);
    fputs(w.change.with, stdout);
    fwrite(s.text + behind, 1, s.size - behind, stdout);
    free_source(&s);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc > 4 && strcmp(argv[1], "list") == 0) {
        return list(strtoull(argv[2], NULL, 10), atoi(argv[3]), argv + 4, argc - 4);
    }
    if (argc == 4 && strcmp(argv[1], "apply") == 0) {
        return apply(argv[2], atoi(argv[3]));
    }
    fprintf(stderr, "usage: mutate list SEED N FILE... | mutate apply FILE NUMBER\n");
    return 2;
}
