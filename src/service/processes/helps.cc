#include "src/service/processes/helps.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tessera::service {
namespace {

// What the inputs of all processes mean, by name: equal names mean the same.
constexpr std::pair<const char*, const char*> helps[] = {
    {"inputs", "Files, folders or patterns below the folders that the service has for inputs, or upload:NAME/FILE."},
    {"output",
     "The name of the result or file that the job makes; default: the service chooses one. "
     "Of a change: the name of a new result; default: the result itself gets a new version."},
    {"dim",
     "The dimension of the triangulation, 2 (x and y alone) or 3; default: 3, or 2 when the files hold x and y "
     "alone."},
    {"tiles", "The number of tiles; default: chosen from memory and threads."},
    {"tile_points", "How many points a tile may hold at most; default: chosen from memory and threads."},
    {"partition", "How space is split into tiles: kdtree (default), grid, octree, or random, which is for tests."},
    {"threads", "How many threads the job may use."},
    {"memory", "How much memory the job may use: a number with K, M, G or T."},
    {"kernel", "The Delaunay kernel, which triangulates each tile: flat (default) or cgal."},
    {"store",
     "What the result stores of its tiles: cells; points, which takes a tenth of the bytes; or auto (default), which "
     "stores points for clouds of more than 50 million points."},
    {"neighbors", "Also store the neighbours of each cell; without them the files are half as large."},
    {"crop", "Keep only points in this box: the coordinates of its lower corner, then of its upper corner."},
    {"class", "Keep only points of these LAS classes."},
    {"attributes", "The attributes of the points that the result carries, by name; all means all of them."},
    {"resolution",
     "COPC and EPT: read only the octree levels down to the first whose points are at most this far apart; default: "
     "all levels."},
    {"columns",
     "Text and NumPy files: the names of the columns, in order: x, y, z, the name of an attribute, or _ for a column "
     "to leave out."},
    {"crs", "The coordinate system of all input files, whatever the files say: EPSG:n or WKT."},
    {"returns", "LAS files: keep all returns of each pulse (default), or only the first, last or single one."},
    {"scan", "E57 and PTX files: keep only points of these scans, numbered from 0."},
    {"without", "LAS files: leave out points with one of these flags."},
    {"recursive", "Also take the files in subfolders of input folders."},
    {"overwrite", "Replace a result or file that already has the name of the output."},
    {"keep",
     "2D: which of several points with equal x and y becomes the vertex: the first (default), last, lowest or "
     "highest."},
    {"heights",
     "2D: keep the heights: a result carries them as the attribute z, and files have them as the third coordinate."},
    {"periodic",
     "The periods of a periodic cloud: one number for all axes, or one for each, 0 for an axis without one."},
    {"periodic_snap",
     "Round coordinates and periods that have too many binary digits for exact images (true by default), or refuse "
     "them."},
    {"skip_invalid", "Leave out points with NaN or infinite coordinates and count them, instead of refusing the file."},
    {"triangulation", "The name of a result."},
    {"version", "The version of the result, if it is still kept; default: the newest."},
    {"against_cgal", "Also compare the result with a triangulation that CGAL computes in memory."},
    {"format", "The format of the file; default: the format of the ending of output, or of copies that of each file."},
    {"local",
     "ply, obj, off, stl: write coordinates relative to the lower corner of the result's box, for programs that keep "
     "them as floats."},
    {"names",
     "h5, fits, table, ndnet: the attributes and computed columns of vertices that are written; default: all, for "
     "ndnet "
     "density."},
    {"spatial_index", "GeoPackage: also write a spatial index of the cells."},
    {"max_edge", "Leave out cells with a longer edge."},
    {"max_radius", "Leave out cells with a larger circumradius, in 2D in the plane."},
    {"stats", "Also read all points, and give statistics of them."},
    {"bbox", "Only what is in this box: the coordinates of its lower corner, then of its upper corner."},
    {"polygon", "The region, as text: polygons in GeoJSON, in the coordinates of the points."},
    {"max_points", "Triangulate at most this many points; default: as many as the memory allows."},
    {"max_seconds", "Give up after about this many seconds; default: never."},
    {"partial",
     "When max_points, max_seconds or the memory is used up, store the cells that are known, instead of failing."},
    {"scan_files",
     "Read all files once to see where their points are, instead of relying on the boxes that the files state."},
    {"res", "The width of a pixel or voxel, in units of the coordinates."},
    {"value", "The attribute of the vertices to draw, or to take as heights; default: z, the heights."},
    {"type", "The type of the pixels: float32 (default) or float64."},
    {"method",
     "How values follow from the vertices: linear in each cell (default), natural (Sibson's natural neighbours), or "
     "laplace (natural neighbours, with other weights)."},
    {"hillshade", "Draw a hillshade of the surface instead of the heights."},
    {"azimuth", "hillshade: the direction of the light, in degrees clockwise from north; default: 315."},
    {"altitude", "hillshade: the height of the light above the horizon, in degrees; default: 45."},
    {"interval", "The distance between levels, in units of the heights."},
    {"base",
     "Contour lines: the height of one of the levels; default: 0. Volumes: polygons as text in GeoJSON, whose vertices "
     "have heights and span the second surface; each polygon is a row."},
    {"smooth",
     "Draw lines of a smooth surface, the means of the surface in squares of this size; default: lines of the "
     "surface itself."},
    {"min_length", "Leave out lines that are shorter in the plane; default: keep all lines."},
    {"sensor",
     "Where the sensor was that saw the points: auto (default: the best that the points tell), vertical (straight "
     "above), fields (attributes of the points), scan-angle, or point:X,Y,Z;..."},
    {"lambda", "How much the quality of triangles counts; a larger number makes a smoother surface; default: 1."},
    {"alpha",
     "Surfaces: how much a ray, the line from a point to its sensor, counts; default: 32. Alpha shapes: a radius, in "
     "units of the coordinates; cells of a circumradius up to it make the shape; default: the least radius for which "
     "the shape is one piece that has all points."},
    {"sigma",
     "How far a point may be from the surface, in units of the coordinates; default: for each point from the length "
     "of its edges."},
    {"ray_length", "How far a ray goes towards its sensor, as a multiple of sigma; full: all the way; default: 100."},
    {"bottom",
     "What is below all points: closed (default): inside, and the surface has a bottom; open: inside, but the "
     "surface has no bottom; free: outside."},
    {"unknown", "What a place is that no ray has seen: solid (default) or empty."},
    {"trim", "Leave out triangles with a longer edge; the surface is then not closed."},
    {"manifold",
     "Split vertices and edges where the surface touches itself, for programs that need a manifold; no vertex "
     "moves."},
    {"smoothing", "How many rounds of smoothing, which move the vertices; default: 0."},
    {"index_every", "Every N-th level, from base on, is an index line; default: 5."},
    {"outside", "The height of points outside of the hull of the ground; default: NaN."},
    {"replace",
     "Heights: replace the dimension HeightAboveGround that a file has already. Changes: new points take the places of "
     "all points with the same coordinates."},
    {"remove_ids", "Remove the points with these source indices."},
    {"remove_ids_file",
     "Remove the points whose source indices are in this NumPy file, which is named as inputs are; for long lists."},
    {"remove_class", "Remove the points whose attribute classification has one of these values."},
    {"remove_box",
     "Remove the points in this box: the coordinates of its lower corner, then of its upper corner; four numbers for "
     "any "
     "height."},
    {"remove_polygon",
     "Remove the points in these polygons, at any height: text in GeoJSON, in the coordinates of the result."},
    {"remove_time", "Remove the points whose attribute gps_time is from the first to the second of these numbers."},
    {"remove_input", "Remove the points that came from these files, which need not exist any more."},
    {"keep_versions",
     "How many of the newest versions of the result stay readable, also after later changes; default: as before, at "
     "first 1."},
    {"dry_run", "Write nothing, and tell what would change."},
    {"volume", "The volume of each cell, and for each vertex that of the cells around it; for a 2D result areas."},
    {"quality", "The shape of each cell: radius ratio, least and largest angle, circumradius."},
    {"voronoi", "The Voronoi cell of each vertex: its volume, surface, number of neighbours and centroid."},
    {"density",
     "The density of each vertex: dimension + 1 times its mass, divided by the volume of the cells around it; each "
     "point has the mass 1, duplicates included."},
    {"clip",
     "To what cells are clipped: hull (the convex hull; default in 2D), none (default in 3D), a box "
     "xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax, or polygons as text in GeoJSON."},
    {"mass", "The attribute of the vertices that has their masses; default: each point has mass 1."},
    {"field", "Instead of the density, the mean of this attribute of the vertices."},
    {"divergence",
     "Instead of the density, the mean divergence of the vector with these attributes of the vertices as components."},
    {"curl", "Instead of the density, the mean curl of such a vector: in 2D a number, in 3D a vector for each voxel."},
    {"sample", "The values at the centres of pixels or voxels, not the means over them."},
    {"general", "Also write singular facets, edges and vertices, which belong to no cell in the shape."},
    {"second", "The name of the 2D result that is the surface after; the surface before is that of triangulation."},
    {"plane", "The surface after is the level plane at this height."},
    {"within", "Polygons as text in GeoJSON: a row for each of them, with the volumes inside of it."},
    {"name", "The attribute that names the polygons; default: name or id, if there is one."}};

}  // namespace

const char* help_of(std::string_view field) {
  const auto help =
      std::find_if(std::begin(helps), std::end(helps), [&](const auto& each) { return field == each.first; });
  return help == std::end(helps) ? nullptr : help->second;
}

}  // namespace tessera::service
