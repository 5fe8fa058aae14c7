/* SPDX-License-Identifier: GPL-3.0-or-later
 * fmu.h - shared by the files of this folder.
 *
 *   fmu.c         the FMU put together
 *   variables.c   its variables, of both versions  variable_text.c      what they are, in words
 *   description.c modelDescription.xml             xml.c        escaped texts, units
 *   binary.c      core, equations, FMI -> .so, .dll zip.c        the archive
 *
 * The sources of the FMI side are in src/fmi; make puts them and the sources of the core into the
 * program as text.
 * Included by: this folder.
 */
#ifndef LAB_FMU_H
#define LAB_FMU_H

#include "embedded.h"
#include "open.h"
#include "variables.h"

typedef enum { FMU_INDEPENDENT, FMU_OUTPUT, FMU_INPUT, FMU_PARAMETER, FMU_LOCAL } fmu_causality;
typedef enum { FMU_FIXED, FMU_TUNABLE, FMU_DISCRETE, FMU_CONTINUOUS } fmu_variability;

/** One variable. */
typedef struct fmu_variable {
    fmi_variable is;
    unsigned reference;
    char *name, *text;
    const char *unit; /* SI; "1": none */
    fmu_causality causality;
    fmu_variability variability;
    int boolean, has_start;
    double start;
    int derivative_of; /* place in the list, -1: of nothing that is in it */
} fmu_variable;

/** All of them, in the order of modelDescription.xml. */
typedef struct fmu_list {
    const mechanism *m;
    const stein_model *model;
    fmu_variable *v;
    int n;
} fmu_list;

/* ---- variables.c ---- */

/** @return OK, ENOMEM, EINVAL (a name that cannot be made unique) */
stein_status fmu__list_create(fmu_list *list, const lab_model *model, stein_err *err);
void fmu__list_free(fmu_list *list);
/** May a parameter of the equations be changed while it runs? Those of the file's section
 *  `regulation`; without one, of its section `parameters`; without that, all that the file states
 *  and that are not only read at the start. */
int fmu__is_tunable(const mechanism *m, const stein_model *model, int param);
/** Can an output change at once when an input does? */
int fmu__depends(const stein_model *model, const fmu_variable *output, const fmu_variable *input);

/* ---- variable_text.c: new texts; NULL without memory ---- */

char *fmu__words_channel(const fmu_list *list, int channel);
char *fmu__words_input(const fmu_list *list, int input, const char *what);
char *fmu__words_param(const fmu_list *list, int param);
/** Text of the file about an entry of a section, or NULL. */
const char *fmu__about(const mechanism *m, const char *section, const char *entry);

/* ---- xml.c ---- */

/** A text as value of an attribute: nothing of it is markup, what XML does not allow is "?". */
void fmu__escape(FILE *f, const char *text);
/** ' name="text"' */
void fmu__attribute(FILE *f, const char *name, const char *text);
void fmu__attribute_number(FILE *f, const char *name, double value);
/** The element UnitDefinitions, which is the same in both versions. */
void fmu__units(FILE *f, const fmu_list *list);

/* ---- description.c ---- */

/** modelDescription.xml. @param version 2 or 3  @param sources  files to be compiled, closed by
 * NULL */
void fmu__describe(FILE *f, int version, const fmu_list *list, const char *token,
                   const char *const *sources);
/** sources/buildDescription.xml */
void fmu__describe_build(FILE *f, const fmu_list *list, const char *const *sources);

/* ---- binary.c ---- */

enum { FMU_SOURCES = 96, FMU_PLATFORM = 32, FMU_BINARIES = 16 };
/** Sources that are compiled, in the folder sources of the FMU. */
typedef struct fmu_sources {
    char *name[FMU_SOURCES + 1], *text[FMU_SOURCES + 1]; /* owned */
    int n;
    const char *compiled[FMU_SOURCES + 1]; /* names of those that are no headers, closed by NULL */
} fmu_sources;
/** The sources of one version, with equations and the values of the file. @param token  may be
 *  unknown yet: "" @return OK, ENOMEM, EGENERATE */
stein_status fmu__sources_create(fmu_sources *to, const fmu_list *list, int version,
                                 const char *token, stein_err *err);
void fmu__sources_free(fmu_sources *sources);
/** FNV-1a of 64 bits, with one text more and its end. */
unsigned long long fmu__hash(unsigned long long h, const char *text);
/** The lines of a file as one text; NULL without memory. */
char *fmu__joined(const char *const *lines);
/** Result of a compiler. */
typedef struct fmu_binary {
    char *bytes; /* owned */
    size_t size;
    char platform[FMU_PLATFORM]; /* name of the folder in binaries */
    const char *ending;          /* "so", "dll" */
} fmu_binary;
/** Compile them. @param cc  compiler, with options  @return OK, EIO, ENOMEM, ECOMPILE */
stein_status fmu__binary(fmu_binary *to, const fmu_sources *sources, int version, const char *cc,
                         const lab_options *options, stein_err *err);
/** Options that the sources need for the same bits with every compiler. */
extern const char fmu__compiler_options[];

/* ---- zip.c ---- */

/** An archive that is written into memory. */
typedef struct fmu_zip fmu_zip;
stein_status fmu__zip_create(fmu_zip **zip, stein_err *err);
/** Add a file; after a failure, or where name or bytes are NULL, the archive stays failed. */
void fmu__zip_add(fmu_zip *zip, const char *name, const void *bytes, size_t size);
/** End it and write it. @param bytes  out: its size  @return OK, EIO, ENOMEM */
stein_status fmu__zip_write(fmu_zip *zip, const char *path, size_t *bytes, stein_err *err);
void fmu__zip_destroy(fmu_zip *zip);

#endif
