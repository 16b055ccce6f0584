#include "src/base/crs/gdal_library.h"

#include <dlfcn.h>

#include <string>

#include "src/base/crs/crs.h"
#include "src/base/crs/gdal_files.h"
#include "src/base/crs/proj_files.h"
#include "src/base/default_arithmetic.h"

namespace tessera {

namespace {

// The GDAL that Tessera was built with, else a later one (3.7 to 3.12): the interface for C stays the same, and wheels
// run on systems with other versions. GDAL is never unloaded, because it keeps threads and caches.
Result<void*> open_library() {
  std::string missing;
  for (const char* name : {TESSERA_GDAL_SONAME, "libgdal.so.33", "libgdal.so.34", "libgdal.so.35", "libgdal.so.36",
                           "libgdal.so.37", "libgdal.so.38"}) {
    if (void* handle = ::dlopen(name, RTLD_NOW | RTLD_LOCAL)) return handle;
    if (missing.empty()) missing = ::dlerror();
  }
  return error(Errc::io, "coordinate systems need GDAL (Debian's package libgdal32): " + missing);
}

Result<void*> library_handle() {
  static const Result<void*> handle = [] {
    const DefaultArithmetic kept;  // 110 libraries are loaded with GDAL, and some of them may change the arithmetic
    return open_library();
  }();
  return handle;
}

Result<GdalFiles> load_files() {
  BOOST_OUTCOME_TRYV(gdal_library());  // which makes GDAL ready
  BOOST_OUTCOME_TRY(handle, library_handle());
  GdalFiles files;
  const char* missing = nullptr;
  const auto find = [&]<class Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    if (function == nullptr) missing = name;
  };
#define TESSERA_GDAL_FIND(name) find(files.name, #name);
  TESSERA_GDAL_FILE_FUNCTIONS(TESSERA_GDAL_FIND)
#undef TESSERA_GDAL_FIND
  if (missing != nullptr) return error(Errc::io, std::string(TESSERA_GDAL_SONAME) + " has no function " + missing);
  return files;
}

Result<GdalLibrary> load() {
  const DefaultArithmetic kept;
  BOOST_OUTCOME_TRY(handle, library_handle());
  GdalLibrary gdal;
  const char* missing = nullptr;
  const auto find = [&]<class Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    if (function == nullptr) missing = name;
  };
#define TESSERA_GDAL_FIND(name) find(gdal.name, #name);
  TESSERA_GDAL_FUNCTIONS(TESSERA_GDAL_FIND)
#undef TESSERA_GDAL_FIND
  if (missing != nullptr) return error(Errc::io, std::string(TESSERA_GDAL_SONAME) + " has no function " + missing);
  // Must come before GDAL makes its first context of PROJ.
  keep_to_own_files(gdal);
  gdal.GDALRegister_GTiff();
  gdal.GDALRegister_COG();
  gdal.GDALRegister_PNG();
  gdal.GDALRegister_MEM();
  gdal.RegisterOGRFlatGeobuf();
  gdal.RegisterOGRGeoJSON();
  gdal.RegisterOGRGeoPackage();
  gdal.RegisterOGRShape();
  return gdal;
}

void keep_quiet(CPLErr, CPLErrorNum, const char*) {}

// Before GDAL transforms, it looks up the AUTHORITY of a WKT as if a user had typed "name:code". So it would open a
// file of that name.
constexpr const char* ask_authority = "OGR_CT_PREFER_OFFICIAL_SRS_DEF";
thread_local int quiet_on_this_thread = 0;

}  // namespace

Result<const GdalLibrary*> gdal_library() {
  static const Result<GdalLibrary> gdal = load();
  if (!gdal) return gdal.error();
  return &gdal.value();
}

Result<const GdalFiles*> gdal_files() {
  static const Result<GdalFiles> files = load_files();
  if (!files) return files.error();
  return &files.value();
}

GdalQuiet::GdalQuiet(const GdalLibrary& gdal) : gdal_(gdal) {
  gdal_.CPLPushErrorHandler(keep_quiet);
  gdal_.CPLErrorReset();
  if (quiet_on_this_thread++ == 0) gdal_.CPLSetThreadLocalConfigOption(ask_authority, "NO");
}

GdalQuiet::~GdalQuiet() {
  if (--quiet_on_this_thread == 0) gdal_.CPLSetThreadLocalConfigOption(ask_authority, nullptr);
  gdal_.CPLPopErrorHandler();
}

std::string GdalQuiet::message() const {
  const std::string message = gdal_.CPLGetLastErrorMsg();
  return message.empty() ? "GDAL gives no reason" : message;
}

Result<SpatialReference> SpatialReference::parse(const GdalLibrary& gdal, const std::string& text) {
  const GdalQuiet quiet(gdal);
  std::string wkt = text.empty() ? undefined_crs : text;
  if (const auto checked = check_crs_text(wkt); !checked)
    return error(Errc::bad_input, "the coordinate system " + checked.error().where);
  SpatialReference reference(gdal, gdal.OSRNewSpatialReference(nullptr));
  const auto code = code_in(wkt);
  // OSRSetFromUserInput() must not be used. It takes a text for a string of PROJ, for an address, and in the end for a
  // file name.
  char* at = wkt.data();
  if ((code ? gdal.OSRImportFromEPSG(reference.get(), *code) : gdal.OSRImportFromWkt(reference.get(), &at)) !=
      OGRERR_NONE)
    return error(Errc::bad_input, "the coordinate system is not understood: " + quiet.message());
  // Coordinates are x, y as they were read, whatever the order of axes of an authority.
  gdal.OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return reference;
}

std::string epsg_code(const GdalLibrary& gdal, OGRSpatialReferenceH reference) {
  const char* authority = gdal.OSRGetAuthorityName(reference, nullptr);
  const char* code = gdal.OSRGetAuthorityCode(reference, nullptr);
  return authority != nullptr && code != nullptr && std::string(authority) == "EPSG" ? code : "";
}

bool equivalent(const GdalLibrary& gdal, OGRSpatialReferenceH a, OGRSpatialReferenceH b) {
  const char* const options[] = {"CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS",
                                 "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
  return gdal.OSRIsSameEx(a, b, options) != 0;
}

}  // namespace tessera
