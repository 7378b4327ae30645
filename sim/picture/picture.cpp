#include "sim/picture/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim/basics/write_bytes.h"
#include "sim/picture/camera.h"
#include "sim/picture/rasteriser.h"

namespace tiltfeed::sim {
namespace {

constexpr int kOversample = 2;  // pixels drawn per pixel of the picture, each way
// Linear colours.
constexpr Colour kTop{0.90, 0.92, 0.95}, kBottom{0.62, 0.66, 0.71};
constexpr Colour kPartColour{0.36, 0.43, 0.50}, kUncutColour{0.12, 0.26, 0.80},
    kUnreachedColour{0.42, 0.06, 0.62};
constexpr std::array<Colour, 3> kPassColours{Colour{1.0, 0.56, 0.03}, Colour{0.93, 0.13, 0.03},
                                             Colour{0.50, 0.008, 0.12}};
constexpr Colour kRapidColour{0.01, 0.33, 0.42}, kAxisColour{0.010, 0.020, 0.075};
// Facets that meet at less than this are shaded as one smooth surface.
constexpr double kCreaseCosine = 0.82;
// Widths in pixels of the picture, lengths in radii of the scene.
constexpr double kCutWidth = 2.0, kRapidWidth = 1.1, kAxisWidth = 1.5, kAxisDot = 4.5, kDash = 7.0;
constexpr double kTurn = 0.01, kTurnCosine = 0.7;
constexpr double kMarkWidth = 1.0, kMarkAlpha = 0.5;
constexpr double kAxisLength = 0.10, kBias = 0.004, kHollowRange = 0.03, kHollowRadius = 14.0,
                 kHollowStrength = 0.75;

/// One normal per facet corner: the mean of those facets round the vertex that are nearly level with it.
class CornerNormals {
 public:
  explicit CornerNormals(const pathgen::Mesh& mesh)
      : mesh_(mesh),
        normal_(mesh.facets.size()),
        size_(mesh.facets.size()),
        end_(mesh.vertices.size() + 1, 0),
        around_(mesh.facets.size() * 3) {
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
      const auto& [a, b, c] = mesh.facets[f];
      normal_[f] = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
      size_[f] = length(normal_[f]);
      for (const std::uint32_t v : mesh.facets[f]) ++end_[v + 1];
    }
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) end_[v + 1] += end_[v];
    // Each vertex's begin moves on to its end, which is the next one's begin.
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
      for (const std::uint32_t v : mesh.facets[f]) around_[end_[v]++] = static_cast<std::uint32_t>(f);
  }

  Vec3 operator()(std::size_t facet, int corner) const {
    const std::uint32_t v = mesh_.facets[facet][corner];
    Vec3 sum;
    for (std::uint32_t i = v == 0 ? 0 : end_[v - 1]; i < end_[v]; ++i) {
      const Vec3 other = normal_[around_[i]];
      if (dot(other, normal_[facet]) >= kCreaseCosine * size_[around_[i]] * size_[facet]) sum = sum + other;
    }
    return squared_length(sum) > 0.0 ? normalized(sum) : Vec3{0, 0, 1};
  }

 private:
  const pathgen::Mesh& mesh_;
  std::vector<Vec3> normal_;
  std::vector<double> size_;                 ///< of normal_
  std::vector<std::uint32_t> end_, around_;  ///< around_: by vertex, the facets that meet there
};

/// The lamps, and how a surface looks in them.
class Light {
 public:
  explicit Light(const Camera& camera)
      : key_(normalized(camera.eye() * 0.55 + camera.up() * 0.75 - camera.right() * 0.65)),
        fill_(normalized(camera.eye() * 0.5 + camera.right() * 0.9 + camera.up() * 0.1)) {}

  Colour operator()(Vec3 normal, Vec3 view, Colour of) const {
    if (dot(normal, view) < 0.0) normal = -normal;
    const double light = 0.34 + 0.95 * std::max(0.0, dot(normal, key_)) +
                         0.28 * std::max(0.0, dot(normal, fill_)) + 0.12 * dot(normal, view);
    const double mirrored = std::max(0.0, dot(normal, normalized(key_ + view)));
    const double squared = mirrored * mirrored, to_8 = squared * squared * squared * squared;
    const double gloss = to_8 * to_8 * to_8 * to_8 * to_8;
    return of * light + Colour{1, 1, 1} * (0.16 * gloss);
  }

 private:
  Vec3 key_, fill_;
};

Colour colour_of(FacetMark mark) {
  return mark == FacetMark::kUnreached ? kUnreachedColour
         : mark == FacetMark::kUncut   ? kUncutColour
                                       : kPartColour;
}

void draw_part(const pathgen::Mesh& mesh, const std::vector<FacetMark>& marks, const Camera& camera,
               Rasteriser& raster) {
  const CornerNormals normal(mesh);
  const Light light(camera);
  std::vector<ScreenPoint> screen;
  screen.reserve(mesh.vertices.size());
  for (const Point<Part> p : mesh.vertices) screen.push_back(camera.project(p));
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const auto& [a, b, c] = mesh.facets[f];
    raster.triangle({screen[a], screen[b], screen[c]}, [&] {
      const Colour of = colour_of(marks.empty() ? FacetMark::kNone : marks[f]);
      const auto at = [&](int k) {
        return light(normal(f, k), camera.view_from(mesh.vertices[mesh.facets[f][k]]), of);
      };
      return std::array{at(0), at(1), at(2)};
    });
  }
}

/// Edges of unreached facets, through what hides them.
void draw_unreached(const pathgen::Mesh& mesh, const std::vector<FacetMark>& marks, const Camera& camera,
                    Rasteriser& raster) {
  const double in_front = 4.0 * camera.scene_radius();
  for (std::size_t f = 0; f < marks.size(); ++f) {
    if (marks[f] != FacetMark::kUnreached) continue;
    for (int k = 0; k < 3; ++k)
      raster.line(camera.project(mesh.vertices[mesh.facets[f][k]]),
                  camera.project(mesh.vertices[mesh.facets[f][(k + 1) % 3]]), kMarkWidth * kOversample,
                  kUnreachedColour, kMarkAlpha, in_front);
  }
}

/// An unbroken run of cutting moves: moves[first] states where it starts. Runs one behind the other, with
/// gaps in between, are one pass.
struct Run {
  std::size_t first = 0, last = 0;
  int pass = 0;
};

Vec3 across_axis(Vec3 v, Vec3 axis) { return v - axis * dot(v, axis); }

/// Does the path go straight on from run a, over a gap, to run b?
bool goes_on(const std::vector<Move>& moves, const Run& a, const Run& b) {
  const Pose &end = moves[a.last].pose, &start = moves[b.first].pose;
  const Vec3 gap = across_axis(start.tip - end.tip, end.axis);
  std::size_t back = a.last;  // a piece of the run as long as the gap gives its direction
  while (back > a.first && distance(moves[back].pose.tip, end.tip) < length(gap)) --back;
  const Vec3 heading = across_axis(end.tip - moves[back].pose.tip, end.axis);
  return dot(gap, heading) > 0.8 * length(gap) * length(heading);
}

/// Passes that are joined in a zigzag: the runs without the turns, where the tool goes back within `turn` mm.
std::vector<Run> without_turns(const std::vector<Move>& moves, const std::vector<Run>& runs, double turn) {
  std::vector<Run> straight;
  for (const Run& run : runs) {
    std::vector<double> way(run.last - run.first + 1, 0.0);
    for (std::size_t i = 1; i < way.size(); ++i)
      way[i] = way[i - 1] + distance(moves[run.first + i - 1].pose.tip, moves[run.first + i].pose.tip);
    // Each of the four places goes forward only.
    std::array<std::size_t, 4> from{1, 1, 1, 1};
    const auto at = [&](double mm, std::size_t& known) {
      while (known + 1 < way.size() && way[known] < mm) ++known;
      const auto found = way.begin() + static_cast<std::ptrdiff_t>(known);
      const std::size_t i = run.first + static_cast<std::size_t>(found - way.begin());
      const double step = *found - *(found - 1);
      const double share = step > 0.0 ? std::clamp((mm - *(found - 1)) / step, 0.0, 1.0) : 1.0;
      return lerp(moves[i - 1].pose.tip, moves[i].pose.tip, share);
    };
    std::size_t begin = 0;
    for (std::size_t i = 1; i + 1 < way.size(); ++i) {
      if (way[i] < way[begin] + turn || way[i] + 2.0 * turn > way.back()) continue;
      const Vec3 axis = moves[run.first + i].pose.axis;
      const Vec3 in = across_axis(at(way[i], from[1]) - at(way[i] - turn, from[0]), axis);
      const Vec3 out = across_axis(at(way[i] + 2.0 * turn, from[3]) - at(way[i] + turn, from[2]), axis);
      const double both = length(in) * length(out);
      if (both == 0.0 || dot(in, out) > -kTurnCosine * both) continue;
      const double end = way[i] + turn;
      while (way[i] < end) ++i;
      straight.push_back({run.first + begin, run.first + i, 0});
      begin = i;
    }
    straight.push_back({run.first + begin, run.last, 0});
  }
  return straight;
}

/// `turn`: length of the way within which joined passes go back, mm.
std::vector<Run> find_runs(const std::vector<Move>& moves, double turn) {
  std::vector<Run> runs;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    if (moves[i].kind != MoveKind::kCut) continue;
    if (moves[i - 1].kind == MoveKind::kCut && !runs.empty() && runs.back().last == i - 1) {
      runs.back().last = i;
      continue;
    }
    Run run{i - 1, i, runs.empty() ? 0 : runs.back().pass};
    runs.push_back(run);
  }
  runs = without_turns(moves, runs, turn);
  for (std::size_t r = 1; r < runs.size(); ++r)
    runs[r].pass = runs[r - 1].pass + (goes_on(moves, runs[r - 1], runs[r]) ? 0 : 1);
  return runs;
}

Colour pass_colour(double f) {
  const double at = std::clamp(f, 0.0, 1.0) * 2.0;
  const int i = at >= 1.0 ? 1 : 0;
  return kPassColours[i] + (kPassColours[i + 1] - kPassColours[i]) * (at - i);
}

class PathPainter {
 public:
  PathPainter(const std::vector<Move>& moves, const Camera& camera, Rasteriser& raster)
      : moves_(moves), camera_(camera), raster_(raster), bias_(kBias * camera.scene_radius()) {}

  void cut(const Run& run, Colour colour) {
    ScreenPoint from = at(run.first);
    for (std::size_t i = run.first + 1; i <= run.last; ++i) {
      const ScreenPoint to = at(i);
      if (i < run.last && std::hypot(to.x - from.x, to.y - from.y) < 1.0) continue;
      raster_.line(from, to, kCutWidth * kOversample, colour, 1.0, bias_);
      from = to;
    }
  }

  /// The dashes run on over all moves of the rapid.
  void rapid(std::size_t first, std::size_t last) {
    double way = 0.0;
    const double dash = kDash * kOversample;
    for (std::size_t i = first + 1; i <= last; ++i) {
      const ScreenPoint a = at(i - 1), b = at(i);
      const double whole = std::hypot(b.x - a.x, b.y - a.y);
      if (whole > 1e6) continue;
      const auto mix = [&](double f) {
        return ScreenPoint{a.x + (b.x - a.x) * f, a.y + (b.y - a.y) * f, a.depth + (b.depth - a.depth) * f};
      };
      for (double done = 0.0; done < whole;) {
        const double phase = std::fmod(way, 2.0 * dash),
                     left = phase < dash ? dash - phase : 2.0 * dash - phase;
        const double next = std::min(whole, done + std::max(left, 1e-3));
        if (phase < dash)
          raster_.line(mix(done / whole), mix(next / whole), kRapidWidth * kOversample, kRapidColour, 0.75,
                       bias_);
        way += next - done, done = next;
      }
    }
  }

  void axis(std::size_t i) {
    const Pose& pose = moves_[i].pose;
    const ScreenPoint from = at(i),
                      to = camera_.project(pose.tip + pose.axis * (kAxisLength * camera_.scene_radius()));
    raster_.line(from, to, kAxisWidth * kOversample, kAxisColour, 1.0, 2.0 * bias_);
    raster_.disc(from, kAxisDot * kOversample, kAxisColour, 2.0 * bias_);
  }

 private:
  ScreenPoint at(std::size_t i) const { return camera_.project(moves_[i].pose.tip); }

  const std::vector<Move>& moves_;
  const Camera& camera_;
  Rasteriser& raster_;
  double bias_;
};

void draw_path(const std::vector<Move>& moves, const PictureOptions& options, const Camera& camera,
               Rasteriser& raster) {
  const std::vector<Run> runs = find_runs(moves, kTurn * camera.scene_radius());
  if (runs.empty()) return;
  const int passes = runs.back().pass + 1,
            every = (passes + options.passes - 1) / std::max(1, options.passes);
  const auto drawn = [&](const Run& run) { return run.pass % every == every / 2; };
  PathPainter painter(moves, camera, raster);
  if (options.rapids) {
    for (std::size_t r = 0; r <= runs.size(); ++r) {
      const bool wanted = (r > 0 && drawn(runs[r - 1])) || (r < runs.size() && drawn(runs[r]));
      const std::size_t first = r > 0 ? runs[r - 1].last : 0,
                        last = r < runs.size() ? runs[r].first : moves.size() - 1;
      const bool cutting = first + 1 < moves.size() && moves[first + 1].kind == MoveKind::kCut && r > 0;
      if (wanted && !cutting) painter.rapid(first, last);
    }
  }
  double whole = 0.0;
  for (const Run& run : runs) {
    if (!drawn(run)) continue;
    painter.cut(run, pass_colour(passes > 1 ? static_cast<double>(run.pass) / (passes - 1) : 0.0));
    for (std::size_t i = run.first + 1; i <= run.last; ++i)
      whole += distance(moves[i - 1].pose.tip, moves[i].pose.tip);
  }
  // Half a step in, so that neighbouring passes do not show their axes side by side.
  const double step = whole / std::max(1, options.axes);
  double since = 0.5 * step;
  for (const Run& run : runs) {
    if (!drawn(run)) continue;
    for (std::size_t i = run.first + 1; i <= run.last; ++i) {
      since += distance(moves[i - 1].pose.tip, moves[i].pose.tip);
      if (since >= step && options.axes > 0) painter.axis(i), since = std::fmod(since, step);
    }
  }
}

}  // namespace

Result<std::string> part_with_path(const pathgen::Mesh& part, const ToolPath& path,
                                   const PictureOptions& options) {
  if (part.facets.empty()) return fail(Code::kInput, "no picture: the part has no facets");
  if (options.width < 16 || options.height < 16 || options.width > 8192 || options.height > 8192)
    return fail(Code::kInput, "no picture: each side must have 16 to 8192 pixels");
  if (!options.marks.empty() && options.marks.size() != part.facets.size())
    return fail(Code::kInput, "no picture: the marks are not of this part");
  const int width = options.width * kOversample, height = options.height * kOversample;
  const Camera camera(part, path, width, height);
  Rasteriser raster(width, height, {kTop, kBottom});
  draw_part(part, options.marks, camera, raster);
  raster.shade_hollows(kHollowRadius * kOversample, kHollowRange * camera.scene_radius(), kHollowStrength);
  draw_path(path.moves, options, camera, raster);
  draw_unreached(part, options.marks, camera, raster);
  return raster.png(kOversample);
}

Result<void> draw_part_with_path(const pathgen::Mesh& part, const ToolPath& path, const std::string& png_path,
                                 const PictureOptions& options) {
  const Result<std::string> bytes = part_with_path(part, path, options);
  if (!bytes) return fail(bytes.error().code, png_path + ": " + bytes.error().message);
  return write_bytes(png_path, *bytes);
}

}  // namespace tiltfeed::sim
