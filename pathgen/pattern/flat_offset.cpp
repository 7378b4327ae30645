#include "pathgen/pattern/flat_offset.h"

#include <algorithm>
#include <clipper.hpp>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

namespace cl = ClipperLib;

cl::Path path_of(const FlatPolygon& polygon) {
  cl::Path path;
  path.reserve(polygon.size());
  for (const auto& p : polygon)
    path.emplace_back(std::llround(p[0] / kFlatGrain), std::llround(p[1] / kFlatGrain));
  return path;
}

FlatPolygon polygon_of(const cl::Path& path, bool positive) {
  FlatPolygon polygon;
  polygon.reserve(path.size());
  for (const cl::IntPoint& p : path)
    polygon.push_back({static_cast<double>(p.X) * kFlatGrain, static_cast<double>(p.Y) * kFlatGrain});
  if (cl::Orientation(path) != positive) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

void collect(const cl::PolyNode& node, std::vector<FlatRegion>& regions) {
  for (const cl::PolyNode* border : node.Childs) {
    FlatRegion region{polygon_of(border->Contour, true), {}};
    for (const cl::PolyNode* hole : border->Childs) region.holes.push_back(polygon_of(hole->Contour, false));
    regions.push_back(std::move(region));
    for (const cl::PolyNode* hole : border->Childs) collect(*hole, regions);
  }
}

}  // namespace

std::vector<FlatRegion> regions_of(const std::vector<FlatPolygon>& polygons) {
  std::vector<FlatRegion> regions;
  cl::Clipper clipper;
  for (const FlatPolygon& polygon : polygons) clipper.AddPath(path_of(polygon), cl::ptSubject, true);
  cl::PolyTree tree;
  clipper.Execute(cl::ctUnion, tree, cl::pftEvenOdd);
  collect(tree, regions);
  return regions;
}

std::vector<FlatRegion> moved_inwards(const std::vector<FlatRegion>& regions, double distance,
                                      double tolerance) {
  cl::ClipperOffset offset(2.0, tolerance / kFlatGrain);
  for (const FlatRegion& region : regions) {
    offset.AddPath(path_of(region.border), cl::jtRound, cl::etClosedPolygon);
    for (const FlatPolygon& hole : region.holes)
      offset.AddPath(path_of(hole), cl::jtRound, cl::etClosedPolygon);
  }
  cl::PolyTree tree;
  offset.Execute(tree, -distance / kFlatGrain);
  std::vector<FlatRegion> left;
  collect(tree, left);
  return left;
}

bool in_region(const FlatRegion& region, double x, double y) {
  if (!in_polygon(region.border, x, y)) return false;
  for (const FlatPolygon& hole : region.holes)
    if (in_polygon(hole, x, y)) return false;
  return true;
}

}  // namespace tiltfeed::pathgen
