/* Writes the FITS files of this folder with CFITSIO, so that the reader meets another program's files:
     cc make_fits.c -o make_fits -lcfitsio && ./make_fits
   Row i, from 0, of all tables is a formula of i; tests/input/fits_reader_test.cc has the same formulas. */
#include <fitsio.h>
#include <stdio.h>
#include <stdlib.h>

static int status = 0;

static void check(void) {
  if (status == 0) return;
  fits_report_error(stderr, status);
  exit(1);
}

enum { rows = 7 };

/* Places on the sky, and a column of each type. */
static void catalogue(void) {
  fitsfile* file;
  char* types[] = {"ID", "RA", "DEC", "Z", "MAG", "COUNT", "BIG", "SIGNED", "FLAG", "BYTE", "SCALED", "NAME", "BITS",
                   "SHAPE", "WAVE", "MISSING"};
  char* forms[] = {"1W", "1D", "1D", "1E", "1E", "1U", "1V", "1S", "1L", "1B", "1I", "8A", "12X", "3E", "1C", "1J"};
  char* units[] = {"", "deg", "deg", "", "mag", "", "", "", "", "", "km/s", "", "", "arcsec", "", ""};
  fits_create_file(&file, "!catalogue.fits", &status);
  fits_create_tbl(file, BINARY_TBL, 0, 16, types, forms, units, "GALAXIES", &status);
  check();
  double scale = 0.5, zero = 100;
  fits_update_key(file, TDOUBLE, "TSCAL11", &scale, "", &status);
  fits_update_key(file, TDOUBLE, "TZERO11", &zero, "", &status);
  LONGLONG null = -99;
  fits_update_key(file, TLONGLONG, "TNULL16", &null, "", &status);
  fits_set_hdustruc(file, &status);
  for (int i = 0; i < rows; ++i) {
    unsigned long long id = 18446744073709551615ULL - (unsigned long long)i;
    double ra = 51.0 * i, dec = -85 + 25.0 * i;
    float z = 0.1f * (float)i, mag = 20 - (float)i;
    unsigned short count = (unsigned short)(65535 - i);
    unsigned int big = 4294967295u - (unsigned)i;
    signed char is_signed = (signed char)(-128 + i);
    char flag = (char)(i % 2);
    unsigned char byte = (unsigned char)(255 - i);
    double scaled = 100 + 0.5 * i;
    char text[9];
    char* name = text;
    sprintf(text, "galaxy %d", i);
    char bits[12] = {1, 0, 1};
    float shape[3] = {(float)i, i + 0.25f, i + 0.5f}, wave[2] = {1, 2};
    int missing = i == 3 ? -99 : i;
    fits_write_col(file, TULONGLONG, 1, i + 1, 1, 1, &id, &status);
    fits_write_col(file, TDOUBLE, 2, i + 1, 1, 1, &ra, &status);
    fits_write_col(file, TDOUBLE, 3, i + 1, 1, 1, &dec, &status);
    fits_write_col(file, TFLOAT, 4, i + 1, 1, 1, &z, &status);
    fits_write_col(file, TFLOAT, 5, i + 1, 1, 1, &mag, &status);
    fits_write_col(file, TUSHORT, 6, i + 1, 1, 1, &count, &status);
    fits_write_col(file, TUINT, 7, i + 1, 1, 1, &big, &status);
    fits_write_col(file, TSBYTE, 8, i + 1, 1, 1, &is_signed, &status);
    fits_write_col(file, TLOGICAL, 9, i + 1, 1, 1, &flag, &status);
    fits_write_col(file, TBYTE, 10, i + 1, 1, 1, &byte, &status);
    fits_write_col(file, TDOUBLE, 11, i + 1, 1, 1, &scaled, &status);
    fits_write_col(file, TSTRING, 12, i + 1, 1, 1, &name, &status);
    fits_write_col(file, TBIT, 13, i + 1, 1, 12, bits, &status);
    fits_write_col(file, TFLOAT, 14, i + 1, 1, 3, shape, &status);
    fits_write_col(file, TCOMPLEX, 15, i + 1, 1, 1, wave, &status);
    fits_write_col(file, TINT, 16, i + 1, 1, 1, &missing, &status);
    check();
  }
  fits_close_file(file, &status);
  check();
}

/* An image in the primary HDU, another behind it, a table of positions, one of x, y, z with an array of variable
   length, and a table in text. */
static void several(void) {
  fitsfile* file;
  long axes[2] = {9, 5};
  float pixels[45] = {0};
  fits_create_file(&file, "!several.fits", &status);
  fits_create_img(file, FLOAT_IMG, 2, axes, &status);
  fits_write_img(file, TFLOAT, 1, 45, pixels, &status);
  fits_create_img(file, FLOAT_IMG, 2, axes, &status);
  fits_write_img(file, TFLOAT, 1, 45, pixels, &status);
  char* text_types[] = {"X"};
  char* text_forms[] = {"F8.3"};
  double number = 1.5;
  fits_create_tbl(file, ASCII_TBL, 0, 1, text_types, text_forms, NULL, "TEXT", &status);
  fits_write_col(file, TDOUBLE, 1, 1, 1, 1, &number, &status);
  char* types[] = {"pos", "mass"};
  char* forms[] = {"3D", "1E"};
  char* units[] = {"Mpc", "Msun"};
  fits_create_tbl(file, BINARY_TBL, 0, 2, types, forms, units, "HALOS", &status);
  for (int i = 0; i < rows; ++i) {
    double pos[3] = {i, 10.5 + i, 20.25 + i * i};
    float mass = 1000 + (float)i;
    fits_write_col(file, TDOUBLE, 1, i + 1, 1, 3, pos, &status);
    fits_write_col(file, TFLOAT, 2, i + 1, 1, 1, &mass, &status);
  }
  char* more[] = {"X", "y", "Z", "TRACE", "XPOS", "YPOS"};
  char* more_forms[] = {"1J", "1I", "1D", "1PE", "1E", "1E"};
  fits_create_tbl(file, BINARY_TBL, 0, 6, more, more_forms, NULL, "PARTS", &status);
  for (int i = 0; i < rows; ++i) {
    int x = i - 3;
    short y = (short)(-i);
    double z = i / 8.0;
    float trace[4] = {1, 2, 3, 4}, at[2] = {(float)(2 * i), (float)(i * i)};
    fits_write_col(file, TINT, 1, i + 1, 1, 1, &x, &status);
    fits_write_col(file, TSHORT, 2, i + 1, 1, 1, &y, &status);
    fits_write_col(file, TDOUBLE, 3, i + 1, 1, 1, &z, &status);
    fits_write_col(file, TFLOAT, 4, i + 1, 1, 1 + i % 4, trace, &status);
    fits_write_col(file, TFLOAT, 5, i + 1, 1, 1, &at[0], &status);
    fits_write_col(file, TFLOAT, 6, i + 1, 1, 1, &at[1], &status);
  }
  fits_close_file(file, &status);
  check();
}

int main(void) {
  catalogue();
  several();
  return 0;
}
