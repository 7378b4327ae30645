// What two programs of a ball leave of one part, at the same random places of its surface: exact distances of
// the places from the ways of the ball's centre. It shares no code with what finds ridges in the planner.
//
//   left_by_programs FILE.stl MM_A_UNIT RADIUS_MM MOST_MM TOLERANCE_MM BORDER_MM ONE.cl OTHER.cl
//
// The paths are those that `tiltfeed unpost` reads from the programs. MOST_MM is what is left at most between
// the first one's passes. Nearer to places with more left than BORDER_MM nothing is compared: there its
// passes end. Prints one line of JSON.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "sim/solid/distance.h"
#include "tests/judges/surface_sample.h"

namespace {
using namespace tiltfeed;

constexpr int kPlaces = 100'000;
constexpr double kLeans = 0.2588;  // sine of 15 degrees: steeper walls are counted apart

/// The cutting moves, and how the tool stands at each.
struct Track {
  Mesh mesh;
  std::vector<Vec3> axes;
};

/// What is not rapid counts, plunges too. The lines are those that unpost writes.
Track track_of(const char* name, double radius) {
  std::ifstream in(name);
  Track track;
  bool is_rapid = false, begins = true;
  for (std::string line; std::getline(in, line);) {
    Point<Part> tip;
    Vec3 axis;
    if (line == "RAPID") is_rapid = true;
    if (std::sscanf(line.c_str(), "GOTO/%lf,%lf,%lf,%lf,%lf,%lf", &tip.x, &tip.y, &tip.z, &axis.x, &axis.y,
                    &axis.z) != 6)
      continue;
    const auto v = static_cast<std::uint32_t>(track.mesh.vertices.size());
    track.mesh.vertices.push_back(tip + axis * radius);
    if (!is_rapid && !begins) track.mesh.facets.push_back({v - 1, v, v}), track.axes.push_back(axis);
    is_rapid = begins = false;
  }
  return track;
}

/// Of the places that the first program cuts.
struct Found {
  std::size_t count = 0, more = 0;        ///< `more`: the other leaves over MOST_MM and the tolerance
  double one = 0.0, other = 0.0;          ///< the most, mm
  double one_sum = 0.0, other_sum = 0.0;  ///< mm; of the other no more than its radius at a place
};

struct Place {
  SurfaceSample::At at;
  double left = 0.0;
  Vec3 axis;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 9) return std::fprintf(stderr, "see the head of left_by_programs.cpp\n"), 2;
  const double radius = std::atof(argv[3]), most = std::atof(argv[4]), tolerance = std::atof(argv[5]),
               border = std::atof(argv[6]);
  const auto stl = read_stl(argv[1], std::atof(argv[2]));
  const auto part = stl ? check_mesh(*stl) : Result<CheckedMesh>(tl::unexpected(stl.error()));
  if (!part) return std::fprintf(stderr, "%s\n", part.error().message.c_str()), 1;
  const Track one = track_of(argv[7], radius), other = track_of(argv[8], radius);
  if (one.axes.empty() || other.axes.empty()) return std::fprintf(stderr, "no moves\n"), 1;
  const sim::PartDistance by_one(one.mesh), by_other(other.mesh);
  SurfaceSample surface(part->mesh);
  std::vector<Place> cut;
  Mesh not_cut;  // places, as facets without area
  for (int i = 0; i < kPlaces; ++i) {
    const SurfaceSample::At at = surface.next();
    const sim::Hit hit = by_one.nearest(at.point);
    if (const double left = hit.value - radius; left <= most) {
      cut.push_back({at, left, one.axes[hit.facet]});
      continue;
    }
    const auto v = static_cast<std::uint32_t>(not_cut.vertices.size());
    not_cut.vertices.push_back(at.point), not_cut.facets.push_back({v, v, v});
  }
  const sim::PartDistance beyond(not_cut);
  Found leaning, walls;
  for (const Place& place : cut) {
    if (beyond.nearest(place.at.point, border).value < border) continue;
    Found& found = dot(place.at.normal, place.axis) >= kLeans ? leaning : walls;
    const double others = by_other.nearest(place.at.point).value - radius;
    ++found.count;
    found.more += others > most + tolerance ? 1 : 0;
    found.one = std::max(found.one, place.left), found.other = std::max(found.other, others);
    found.one_sum += place.left, found.other_sum += std::min(others, radius);
  }
  const auto json = [](const Found& f) {
    const double count = std::max(1.0, static_cast<double>(f.count));
    std::printf("{\"places\": %zu, \"more\": %zu, \"most_mm\": [%.5f, %.5f], \"mean_mm\": [%.5f, %.5f]}",
                f.count, f.more, f.one, f.other, f.one_sum / count, f.other_sum / count);
  };
  std::printf("{\"leaning\": "), json(leaning), std::printf(", \"walls\": "), json(walls), std::printf("}\n");
}
