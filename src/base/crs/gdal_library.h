// Loads GDAL when it is first needed. Linking GDAL would add 40 ms to every start of the program, and machines without
// GDAL could run nothing. The interface is that of C, because functions are looked up by name.
#pragma once

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <proj.h>

#include <string>

#include "src/base/result.h"

// The drivers in use, declared as in GDAL's gdal_frmts.h and ogrsf_frmts.h. Each is registered by itself, and whoever
// opens a file names the drivers that may open it. The other
// drivers, which open whatever they are given, are not registered at all.
extern "C" {
void GDALRegister_COG();
void GDALRegister_GTiff();
void GDALRegister_MEM();
void GDALRegister_PNG();
void RegisterOGRFlatGeobuf();
void RegisterOGRGeoJSON();
void RegisterOGRGeoPackage();
void RegisterOGRShape();
}

namespace tessera {

// clang-format off
#define TESSERA_GDAL_FUNCTIONS(F) \
  F(CPLErrorReset) F(CPLGetLastErrorMsg) F(CPLGetLastErrorType) F(CPLPopErrorHandler) F(CPLPushErrorHandler) \
  F(CPLSetThreadLocalConfigOption) F(CSLDestroy) F(GDALClose) F(GDALCreate) F(GDALCreateCopy) F(GDALDEMProcessing) \
  F(GDALDEMProcessingOptionsFree) F(GDALDEMProcessingOptionsNew) F(GDALDEMProcessingOptionsSetProgress) \
  F(GDALDatasetCommitTransaction) F(GDALDatasetCreateLayer) F(GDALDatasetExecuteSQL) F(GDALDatasetGetLayer) F(GDALDatasetGetLayerByName) F(GDALDatasetGetLayerCount) \
  F(GDALDatasetReleaseResultSet) F(GDALDatasetStartTransaction) F(GDALFlushCache) F(GDALGetCacheMax64) \
  F(GDALGetDatasetDriver) F(GDALGetDriverByName) F(GDALGetDriverShortName) F(GDALGetGeoTransform) F(GDALGetProjectionRef) F(GDALGetRasterBand) F(GDALGetRasterCount) \
  F(GDALGetRasterDataType) F(GDALGetRasterXSize) F(GDALGetRasterYSize) F(GDALOpenEx) F(GDALRasterIO) \
  F(GDALRegister_COG) F(GDALRegister_GTiff) F(GDALRegister_MEM) F(GDALRegister_PNG) \
  F(GDALSetCacheMax64) F(GDALSetDescription) F(GDALSetGeoTransform) F(GDALSetMetadataItem) F(GDALSetRasterNoDataValue) \
  F(GDALSetSpatialRef) F(GDALWarp) F(GDALWarpAppOptionsFree) F(GDALWarpAppOptionsNew) F(OCTDestroyCoordinateTransformation) \
  F(OCTNewCoordinateTransformation) F(OCTTransform) F(OGR_FD_GetFieldCount) F(OGR_FD_GetFieldDefn) F(OGR_FD_GetFieldIndex) \
  F(OGR_F_Create) F(OGR_F_Destroy) F(OGR_F_GetFID) F(OGR_F_GetFieldAsDouble) F(OGR_F_GetFieldAsInteger64) F(OGR_F_GetFieldAsString) \
  F(OGR_F_GetGeometryRef) F(OGR_F_IsFieldSetAndNotNull) F(OGR_F_SetFID) F(OGR_F_SetFieldDouble) \
  F(OGR_F_SetFieldInteger64) F(OGR_F_SetFieldNull) F(OGR_F_SetFieldString) F(OGR_F_SetGeometryDirectly) F(OGR_Fld_Create) F(OGR_Fld_Destroy) F(OGR_Fld_GetNameRef) F(OGR_Fld_SetSubType) \
  F(OGR_GT_Flatten) F(OGR_GT_HasZ) \
  F(OGR_G_CreateFromWkb) F(OGR_G_ExportToIsoWkb) F(OGR_G_GetGeometryCount) F(OGR_G_GetGeometryName) F(OGR_G_GetGeometryRef) F(OGR_G_GetGeometryType) \
  F(OGR_G_GetPointCount) F(OGR_G_GetPoints) F(OGR_G_WkbSize) F(OGR_G_IsValid) F(OGR_L_CreateFeature) F(OGR_L_CreateField) \
  F(OGR_L_GetFeatureCount) F(OGR_L_GetGeomType) F(OGR_L_GetLayerDefn) F(OGR_L_GetNextFeature) F(OGR_L_GetSpatialRef) F(OGR_L_SyncToDisk) \
  F(OSRDestroySpatialReference) F(OSREPSGTreatsAsLatLong) F(OSREPSGTreatsAsNorthingEasting) F(OSRExportToWkt) F(OSRFindMatches) F(OSRFreeSRSArray) F(OSRGetAttrValue) \
  F(OSRGetAuthorityCode) F(OSRGetAuthorityName) F(OSRGetLinearUnits) F(OSRGetName) F(OSRGetPROJSearchPaths) \
  F(OSRGetTargetLinearUnits) F(OSRImportFromEPSG) F(OSRImportFromWkt) \
  F(OSRIsCompound) F(OSRIsGeocentric) F(OSRIsGeographic) F(OSRIsLocal) F(OSRIsSameEx) F(OSRNewSpatialReference) \
  F(OSRSetAxisMappingStrategy) F(OSRSetPROJEnableNetwork) F(OSRSetTargetLinearUnits) F(OSRSetVertCS) \
  F(OSRStripVertical) F(RegisterOGRFlatGeobuf) F(RegisterOGRGeoJSON) F(RegisterOGRGeoPackage) \
  F(RegisterOGRShape) F(VSIFCloseL) F(VSIFileFromMemBuffer) F(VSIFree) F(VSIGetMemFileBuffer) F(VSIUnlink) \
  F(proj_context_get_user_writable_directory) F(proj_context_set_file_finder)
// clang-format on

struct GdalLibrary {
#define TESSERA_GDAL_MEMBER(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TESSERA_GDAL_FUNCTIONS(TESSERA_GDAL_MEMBER)
#undef TESSERA_GDAL_MEMBER
};

// The library, loaded once. Error io when GDAL is not installed. Thread-safe.
Result<const GdalLibrary*> gdal_library();

// Until destroyed, GDAL prints nothing on this thread, and looks up no authority that a text names.
class GdalQuiet {
 public:
  explicit GdalQuiet(const GdalLibrary& gdal);
  ~GdalQuiet();
  GdalQuiet(const GdalQuiet&) = delete;
  GdalQuiet& operator=(const GdalQuiet&) = delete;
  // The last message of GDAL.
  std::string message() const;

 private:
  const GdalLibrary& gdal_;
};

// A coordinate system of GDAL, freed by the destructor.
class SpatialReference {
 public:
  // Turns a text into a system. This is the only way from a text to GDAL. The text is WKT of any kind or "EPSG:n"; an
  // empty text is the undefined Cartesian system. Error bad_input for other texts, for texts that name files
  // (check_crs_text() in crs.h), and when GDAL does not understand the text.
  static Result<SpatialReference> parse(const GdalLibrary& gdal, const std::string& text);
  SpatialReference(SpatialReference&& other) noexcept : gdal_(other.gdal_), handle_(other.handle_) {
    other.handle_ = nullptr;
  }
  SpatialReference& operator=(SpatialReference&&) = delete;
  ~SpatialReference() {
    if (handle_ != nullptr) gdal_.OSRDestroySpatialReference(handle_);
  }
  OGRSpatialReferenceH get() const { return handle_; }

 private:
  SpatialReference(const GdalLibrary& gdal, OGRSpatialReferenceH handle) : gdal_(gdal), handle_(handle) {}
  const GdalLibrary& gdal_;
  OGRSpatialReferenceH handle_;
};

// The code of a system that has a code of EPSG; else empty.
std::string epsg_code(const GdalLibrary& gdal, OGRSpatialReferenceH reference);

// Whether two systems mean the same, whatever their names and order of axes.
bool equivalent(const GdalLibrary& gdal, OGRSpatialReferenceH a, OGRSpatialReferenceH b);

}  // namespace tessera
