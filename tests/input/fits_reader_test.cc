// Tables in FITS that CFITSIO wrote (tests/data/fits), and damaged ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "src/input/cosmology.h"
#include "src/input/fits/sky.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

constexpr std::size_t rows_of_test = 7;
const Cosmology concordance{.hubble = 70, .matter = 0.3};

std::string fits_path(const std::string& name) { return TESSERA_TEST_DATA "/fits/" + name; }

Bytes fits_bytes(const std::string& name) {
  std::ifstream in(fits_path(name), std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(in), {}};
  return bytes_of(all);
}

Result<Contents> read_fits(const std::string& name, const std::vector<Attribute>& schema, const ReadHints& hints) {
  return read_bytes(fits_bytes(name), name, schema, hints);
}

std::string refusal_of(const std::string& name, const ReadHints& hints) { return sentence(read_fits(name, {}, hints)); }

// The integral of 1/E by the midpoint rule with long doubles, in 4,000,000 steps.
double slow_distance(const Cosmology& cosmology, double redshift) {
  const int steps = 4'000'000;
  const long double step = static_cast<long double>(redshift) / steps;
  long double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const long double scale = 1 + (i + 0.5L) * step;
    sum += 1 / std::sqrt(cosmology.matter * scale * scale * scale + (1 - static_cast<long double>(cosmology.matter)));
  }
  return static_cast<double>(299792.458L / cosmology.hubble * sum * step);
}

TEST(ComovingDistances, AreThoseOfClosedFormsAndOfASlowIntegral) {
  const ComovingDistance dust({.hubble = 50, .matter = 1}), empty({.hubble = 100, .matter = 0}), usual(concordance),
      heavy({.hubble = 67.4, .matter = 0.9});
  for (const double z : {1e-9, 1e-4, 0.1, 0.125, 0.5, 1.0, 3.0, 7.5, 1100.0, 9999.0}) {
    // Without a constant: 2 c/H0 (1 - 1/sqrt(1 + z)), here without the difference.
    const double root = std::sqrt(1 + z);
    const double exact = 2 * 299792.458 / 50 * z / (root * (root + 1));
    EXPECT_NEAR(dust(z) / exact, 1, 1e-14) << z;
    EXPECT_NEAR(empty(z) / (299792.458 / 100 * z), 1, 1e-14) << z;
  }
  for (const double z : {0.1, 1.0, 6.0}) {
    EXPECT_NEAR(usual(z) / slow_distance(concordance, z), 1, 1e-12) << z;
    EXPECT_NEAR(heavy(z) / slow_distance({.hubble = 67.4, .matter = 0.9}, z), 1, 1e-12) << z;
  }
  EXPECT_NEAR(usual(1), 3303.8288, 1e-4);  // as astropy's FlatLambdaCDM(70, 0.3, Tcmb0=0) says
  EXPECT_EQ(usual(0), 0);
  for (const double z : {-1e-3, 10'001.0, std::nan(""), HUGE_VAL}) EXPECT_TRUE(std::isnan(usual(z))) << z;
}

TEST(ComovingDistances, NeedACosmologyThatCanBe) {
  EXPECT_EQ(why_no_cosmology({.hubble = 70, .matter = 0.3}), "");
  for (const Cosmology& wrong :
       {Cosmology{0, 0.3}, Cosmology{-70, 0.3}, Cosmology{std::nan(""), 0.3}, Cosmology{HUGE_VAL, 0.3},
        Cosmology{70, -0.1}, Cosmology{70, 1.1}, Cosmology{70, std::nan("")}})
    EXPECT_NE(why_no_cosmology(wrong), "");
}

TEST(PlacesOnTheSky, AreExactAtTheAxesAndElsewhereWithinTheLastDigits) {
  using fits::place_on_sky;
  EXPECT_EQ(place_on_sky(0, 0, 2), (Point{2, 0, 0}));
  EXPECT_EQ(place_on_sky(90, 0, 2), (Point{0, 2, 0}));
  EXPECT_EQ(place_on_sky(180, 0, 2), (Point{-2, 0, 0}));
  EXPECT_EQ(place_on_sky(-90, 0, 2), (Point{0, -2, 0}));
  EXPECT_EQ(place_on_sky(630, 0, 2), (Point{0, -2, 0}));
  EXPECT_EQ(place_on_sky(123, 90, 2), (Point{0, 0, 2}));
  EXPECT_EQ(place_on_sky(123, -90, 2), (Point{0, 0, -2}));
  for (int i = 0; i < 2000; ++i) {
    const double ra = i * 0.7313 - 300, dec = std::fmod(i * 1.117, 180) - 90;
    const long double a = ra * std::acos(-1.0L) / 180, d = dec * std::acos(-1.0L) / 180;
    const Point p = place_on_sky(ra, dec, 1000);
    EXPECT_NEAR(p.x, static_cast<double>(1000 * std::cos(d) * std::cos(a)), 1e-12);
    EXPECT_NEAR(p.y, static_cast<double>(1000 * std::cos(d) * std::sin(a)), 1e-12);
    EXPECT_NEAR(p.z, static_cast<double>(1000 * std::sin(d)), 1e-12);
  }
  for (const Point& wrong : {Point{0, 91, 1}, Point{0, 0, -1}, Point{HUGE_VAL, 0, 1}, Point{0, std::nan(""), 1}})
    EXPECT_TRUE(std::isnan(place_on_sky(wrong.x, wrong.y, wrong.z).x));
}

TEST(Fits, PlacesByRedshiftNeedACosmology) {
  EXPECT_EQ(refusal_of("catalogue.fits", {}),
            "catalogue.fits: HDU 1 'GALAXIES' places its points by the redshift 'Z', which is a distance in a "
            "cosmology alone; state a flat one by cosmology: H0 in km/s/Mpc, and the density of matter, as 70,0.3");
  const auto read = read_fits("catalogue.fits", {}, {.cosmology = concordance});
  ASSERT_EQ(sentence(read), "");
  const FileInfo& info = read.value().info;
  EXPECT_EQ(info.format, "fits");
  EXPECT_EQ(info.unit, "Mpc");
  EXPECT_EQ(info.points, rows_of_test);
  EXPECT_EQ(info.detail,
            "FITS, HDU 1 'GALAXIES', coordinates from RA, DEC, Z; left out: NAME (text), BITS (bits), WAVE (complex "
            "numbers)");
  const ComovingDistance distance(concordance);
  ASSERT_EQ(read.value().points.size(), rows_of_test);
  for (std::size_t i = 0; i < rows_of_test; ++i) {
    const auto n = static_cast<double>(i);
    const double z = static_cast<double>(0.1F * static_cast<float>(i));
    EXPECT_EQ(read.value().points[i], fits::place_on_sky(51 * n, -85 + 25 * n, distance(z))) << i;
  }
}

TEST(Fits, ColumnsOfAllTypesAreAttributes) {
  using enum AttributeType;
  const std::vector<Attribute> schema{{"ID", u64},    {"RA", f64},     {"Z", f32},       {"MAG", f32},
                                      {"COUNT", u16}, {"BIG", u32},    {"SIGNED", i8},   {"FLAG", u8},
                                      {"BYTE", u8},   {"SCALED", f64}, {"SHAPE_2", f32}, {"MISSING", f64}};
  const auto read = read_fits("catalogue.fits", schema, {.cosmology = concordance});
  ASSERT_EQ(sentence(read), "");
  std::vector<std::string> units;
  for (const Attribute& wanted : schema) {
    const auto& all = read.value().info.attributes;
    const auto found = std::find(all.begin(), all.end(), wanted);  // with its type
    ASSERT_NE(found, all.end()) << wanted.name;
    if (!found->unit.empty()) units.push_back(found->name + " " + found->unit);
  }
  EXPECT_EQ(units, (std::vector<std::string>{"RA deg", "MAG mag", "SCALED km/s", "SHAPE_2 arcsec"}));
  for (std::size_t i = 0; i < rows_of_test; ++i) {
    const auto at = [&]<class T>(std::size_t column, T) { return cell<T>(read.value(), schema, i, column); };
    const auto n = static_cast<float>(i);
    EXPECT_EQ(at(0, std::uint64_t{}), UINT64_MAX - i);
    EXPECT_EQ(at(1, double{}), 51.0 * static_cast<double>(i));
    EXPECT_EQ(at(2, float{}), 0.1F * n);
    EXPECT_EQ(at(3, float{}), 20 - n);
    EXPECT_EQ(at(4, std::uint16_t{}), 65535 - i);
    EXPECT_EQ(at(5, std::uint32_t{}), 4294967295 - i);
    EXPECT_EQ(at(6, std::int8_t{}), -128 + static_cast<int>(i));
    EXPECT_EQ(at(7, std::uint8_t{}), i % 2);
    EXPECT_EQ(at(8, std::uint8_t{}), 255 - i);
    EXPECT_EQ(at(9, double{}), 100 + 0.5 * static_cast<double>(i));
    EXPECT_EQ(at(10, float{}), n + 0.25F);
    const double missing = at(11, double{});
    EXPECT_TRUE(i == 3 ? std::isnan(missing) : missing == static_cast<double>(i)) << i;
  }
}

TEST(Fits, TheTableAndItsCoordinatesAreChosen) {
  const std::vector<Attribute> schema{{"mass", AttributeType::f32}};
  const auto first = read_fits("several.fits", schema, {});
  ASSERT_EQ(sentence(first), "");
  EXPECT_EQ(first.value().info.unit, "Mpc");
  for (std::size_t i = 0; i < rows_of_test; ++i) {
    const auto n = static_cast<double>(i);
    EXPECT_EQ(first.value().points[i], (Point{n, n + 10.5, 20.25 + n * n}));
    EXPECT_EQ(cell<float>(first.value(), schema, i, 0), 1000 + static_cast<float>(i));
  }
  for (const char* hdu : {"4", "PARTS", "parts"}) {
    const auto read = read_fits("several.fits", {}, {.hdu = hdu});
    ASSERT_EQ(sentence(read), "");
    for (std::size_t i = 0; i < rows_of_test; ++i) {
      const auto n = static_cast<double>(i);
      EXPECT_EQ(read.value().points[i], (Point{n - 3, -n, n / 8}));
    }
    EXPECT_NE(read.value().info.detail.find("TRACE (arrays of variable length)"), std::string::npos);
  }
  const auto flat = read_fits("several.fits", {}, {.columns = {"y=ypos", "x=XPOS"}, .hdu = "4"});
  ASSERT_EQ(sentence(flat), "");
  EXPECT_EQ(flat.value().info.dimension, 2);
  for (std::size_t i = 0; i < rows_of_test; ++i) {
    const auto n = static_cast<double>(i);
    EXPECT_EQ(flat.value().points[i], (Point{2 * n, n * n, 0}));
  }
  const auto sky = read_fits("catalogue.fits", {}, {.columns = {"ra=RA", "dec=DEC", "distance=BYTE"}});
  ASSERT_EQ(sentence(sky), "");
  EXPECT_EQ(sky.value().points[2], fits::place_on_sky(102, -35, 253));
}

TEST(Fits, WhatIsNotThereIsRefusedWithWhatIs) {
  EXPECT_EQ(refusal_of("several.fits", {.hdu = "5"}),
            "several.fits: has no HDU '5'; its tables are HDU 3 'HALOS', HDU 4 'PARTS'");
  EXPECT_EQ(refusal_of("several.fits", {.hdu = "2"}),
            "several.fits: HDU 2 'TEXT', which hdu names, is no binary table");
  EXPECT_EQ(refusal_of("several.fits", {.columns = {"x=U", "y=V"}}),
            "several.fits: HDU 3 'HALOS' has no column of numbers 'U', which columns names; it has pos, mass");
  EXPECT_EQ(refusal_of("several.fits", {.columns = {"x=TRACE", "y=XPOS"}, .hdu = "PARTS"}),
            "several.fits: HDU 4 'PARTS' has no column of numbers 'TRACE', which columns names; it has X, y, Z, XPOS, "
            "YPOS, and, which are no numbers, TRACE (arrays of variable length)");
  EXPECT_EQ(refusal_of("several.fits", {.columns = {"position=mass"}}),
            "several.fits: HDU 3 'HALOS' has 1 number a row in its column 'mass'; a position has three");
  EXPECT_EQ(refusal_of("catalogue.fits", {.columns = {"x=SHAPE", "y=RA"}}),
            "catalogue.fits: HDU 1 'GALAXIES' has 3 numbers a row in its column 'SHAPE'; a coordinate is one");
  EXPECT_EQ(refusal_of("catalogue.fits", {.columns = {"x=ID", "y=RA"}}),
            "catalogue.fits: HDU 1 'GALAXIES' has integers of 64 bits in its column 'ID', which coordinates, as "
            "doubles, would round");
  EXPECT_EQ(refusal_of("catalogue.fits", {.columns = {"ra=SCALED", "dec=DEC", "distance=BYTE"}}),
            "catalogue.fits: HDU 1 'GALAXIES' has the column 'SCALED' in 'km/s'; angles must be in degrees");
}

// Replaces the first card of a key by another one.
Bytes with_card(Bytes bytes, const std::string& key, std::string card) {
  card.resize(80, ' ');
  for (std::size_t at = 0; at + 80 <= bytes.size(); at += 80) {
    if (std::memcmp(bytes.data() + at, key.data(), key.size()) != 0) continue;
    std::memcpy(bytes.data() + at, card.data(), 80);
    return bytes;
  }
  ADD_FAILURE() << key;
  return bytes;
}

std::string damaged(const std::string& key, const std::string& card) {
  return sentence(
      read_bytes(with_card(fits_bytes("catalogue.fits"), key, card), "a.fits", {}, {.cosmology = concordance}));
}

TEST(Fits, HeadersThatLieAreRefused) {
  const std::string hdu = "a.fits, byte 2880: HDU 1 'GALAXIES' ";
  EXPECT_EQ(damaged("NAXIS2  ", "NAXIS2  = 9223372036854775807"),
            hdu + "says that it has more than 2^64 bytes of data, but the file has 2880 behind its header");
  EXPECT_EQ(damaged("NAXIS2  ", "NAXIS2  = 38"),
            hdu + "says that it has 2926 bytes of data, but the file has 2880 behind its header");
  EXPECT_EQ(damaged("NAXIS2  ", "NAXIS2  = -7"), hdu + "has no NAXIS2 of 0 or more");
  EXPECT_EQ(damaged("NAXIS2  ", "NAXIS2  = 0"), hdu + "has no rows");
  EXPECT_EQ(damaged("NAXIS2  ", "NAXIS2  = 'seven'"), hdu + "has no NAXIS2 of 0 or more");
  EXPECT_EQ(damaged("NAXIS1  ", "NAXIS1  = 78"), hdu + "has columns of 77 bytes, but rows of 78, by its NAXIS1");
  EXPECT_EQ(damaged("NAXIS1  ", "NAXIS1  = 60"),
            hdu + "has columns that take more bytes than a row has, by its NAXIS1");
  EXPECT_EQ(damaged("PCOUNT  ", "PCOUNT  = -1"), hdu + "has a PCOUNT or GCOUNT that is no number of 0 or more");
  EXPECT_EQ(damaged("PCOUNT  ", "PCOUNT  = 18446744073709551615"),
            hdu + "has a PCOUNT or GCOUNT that is no number of 0 or more");
  EXPECT_EQ(damaged("PCOUNT  ", "PCOUNT  = 9223372036854775807"),
            hdu + "says that it has 9223372036854776346 bytes of data, but the file has 2880 behind its header");
  EXPECT_EQ(damaged("TFIELDS ", "TFIELDS = 1000"), hdu + "has no TFIELDS from 0 to 999");
  EXPECT_EQ(damaged("TFIELDS ", "TFIELDS = 17"), hdu + "has a column 17 whose TFORM is not known");
  EXPECT_EQ(damaged("TFORM14 ", "TFORM14 = '99999999999999999999E'"), hdu + "has a column 14 whose TFORM is not known");
  EXPECT_EQ(damaged("TFORM14 ", "TFORM14 = '9999999999999999999E'"),
            hdu + "has columns that take more bytes than a row has, by its NAXIS1");
  EXPECT_EQ(damaged("TFORM14 ", "TFORM14 = '3Y'"), hdu + "has a column 14 whose TFORM is not known");
  EXPECT_EQ(damaged("TSCAL11 ", "TSCAL11 = nan"), hdu + "has a column 11 whose TSCAL or TZERO is not a number");
  EXPECT_EQ(damaged("TNULL16 ", "TNULL16 = 0.5"), hdu + "has a column 16 whose TNULL is not an integer");
  EXPECT_EQ(damaged("TSCAL11 ", "TNULL16 = 4"), "a.fits, byte 2880: HDU 1 'GALAXIES' has two cards 'TNULL16'");
  EXPECT_EQ(damaged("TSCAL11 ", "ZTABLE  =                    T"),
            hdu + "is a compressed table, which is not read; unpack the file with funpack");
  EXPECT_EQ(damaged("EXTNAME ", "EXTNAME = 'GALAXIES"),
            "a.fits, byte 2880: HDU 1 has a card 'EXTNAME' whose text has no end");
  EXPECT_EQ(damaged("EXTNAME ", "EXTNAME = 'O''Neill'''"), "");
  EXPECT_EQ(damaged("XTENSION", "XTENSION= 'IMAGE   '"), "a.fits: has no binary table; it holds images alone");
}

TEST(Fits, FilesThatAreCutOffAreRefused) {
  const Bytes whole = fits_bytes("catalogue.fits");
  for (std::size_t size = 30; size < whole.size(); size += 97) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto read = read_bytes(cut, "a.fits", {}, {.cosmology = concordance});
    // Without padding behind the rows, a table is still whole.
    if (read.has_value()) {
      EXPECT_GE(size, 8640 + 77 * rows_of_test);
    } else {
      EXPECT_EQ(sentence(read).find("a.fits"), 0U) << size;
    }
  }
  const Bytes begin(whole.begin(), whole.begin() + 5760);
  EXPECT_EQ(sentence(read_bytes(begin, "a.fits")),
            "a.fits, byte 2880: HDU 1 has a header without an END: the file is cut off or damaged");
}

class FitsCloud : public testing::Test {
 protected:
  static std::string opened(const std::vector<std::string>& files, const CloudOptions& options) {
    return sentence(Cloud::open(files, options));
  }
  static std::string read(const CloudOptions& options) {
    const auto cloud = Cloud::open({fits_path("catalogue.fits")}, options);
    if (!cloud) return sentence(cloud);
    const auto counts = cloud.value().for_each_batch([](CloudBatch&) { return success(); });
    std::string text = sentence(counts);
    if (const auto at = text.find("catalogue.fits"); at != std::string::npos) text.erase(0, at);
    return text;
  }
  TempFolder folder_;
};

TEST_F(FitsCloud, OptionsThatNoFileUsesAreRefused) {
  const std::string text = folder_.write("a.csv", "x,y,z\n1,2,3\n").string();
  EXPECT_EQ(opened({text}, {.hdu = "1"}), "hdu: none of the input files is a FITS table");
  EXPECT_EQ(opened({text}, {.cosmology = concordance}), "cosmology: none of the input files has places by a redshift");
  EXPECT_EQ(opened({text}, {.columns = {"x=X", "y=Y"}}),
            text + ": is no FITS table; columns names its columns in order, as p,y,x,z");
  EXPECT_EQ(opened({fits_path("several.fits")}, {.columns = {"x", "y"}}),
            "columns: none of the input files is text or NumPy, and other files have no columns");
  EXPECT_EQ(opened({fits_path("several.fits"), text}, {}), "");
}

TEST_F(FitsCloud, PointsWithoutAPlaceSayWhy) {
  CloudOptions options{.columns = {"ra=RA", "dec=DEC", "redshift=SIGNED"}, .cosmology = concordance};
  EXPECT_EQ(read(options),
            "catalogue.fits, row 0, whose redshift is -128: x is nan (skip-invalid=true drops such points and counts "
            "them)");
  options.columns = {"ra=RA", "dec=BYTE", "distance=MAG"};
  EXPECT_EQ(read(options), "cosmology: none of the input files has places by a redshift");
  options.cosmology.reset();
  EXPECT_EQ(read(options),
            "catalogue.fits, row 0, whose declination is 255: x is nan (skip-invalid=true drops such points and counts "
            "them)");
}

}  // namespace
}  // namespace tessera::testing_io
