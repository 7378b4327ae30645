#include "tests/attack/judge.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "pathgen/tool/tool_pieces.h"
#include "sim/motion/forward.h"
#include "tests/attack/cover_judge.h"
#include "tests/attack/stock_judge.h"
#include "tests/judges/path_proof.h"
#include "tests/judges/tool_proof.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;
namespace {

/// Places looked at within a block; the post samples eight, so that these fall between.
constexpr int kPlacesOnBlock = 3;
/// Moves of the executed path that are judged; of longer ones a part, in one piece.
constexpr std::size_t kMostMoves = 60'000;
/// Facets lower than this over their longest edge have no area: the reader of the part drops them.
constexpr double kLeastHeight = 1e-6;
/// Poses at which the tool is asked whether it stands wholly inside the material.
constexpr std::size_t kBuriedLooks = 24;
constexpr int kSurfacePoints = 400;
/// Rapids that are held against the blank.
constexpr std::size_t kRapids = 60;
/// Turns of the axis below this (rad) are the post's.
constexpr double kSameDirection = 1e-3;

/// The poses between blocks, as the axes move: all at the same share of their way.
ToolPath executed(const Job& job, const ToolPath& path, const JointPath& joints) {
  ToolPath made = path;
  made.moves.clear(), made.feeds.clear();
  const sim::FrameChain chain(job.machine.model, job.setup);
  for (std::size_t i = 0; i < joints.moves.size() && made.moves.size() < kMostMoves; ++i) {
    const Joints& q = joints.moves[i].joints;
    const Joints& p = joints.moves[i == 0 ? 0 : i - 1].joints;
    const int places = i == 0 ? 1 : kPlacesOnBlock;
    for (int k = 1; k <= places; ++k) {
      const double f = static_cast<double>(k) / places, g = 1.0 - f;
      made.moves.push_back({chain({g * p.x + f * q.x, g * p.y + f * q.y, g * p.z + f * q.z, g * p.a + f * q.a,
                                   g * p.c + f * q.c}),
                            joints.moves[i].kind});
    }
  }
  return made;
}

/// The facets of the file that have an area.
CheckedMesh as_read(const Stl& stl, const CheckedMesh& part) {
  CheckedMesh raw;
  raw.bounds = part.bounds;
  for (const auto& [a, b, c] : stl.facets) {
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    if (!(length(cross(b - a, c - a)) > kLeastHeight * longest)) continue;
    const auto v = static_cast<std::uint32_t>(raw.mesh.vertices.size());
    raw.mesh.vertices.insert(raw.mesh.vertices.end(), {a, b, c});
    raw.mesh.facets.push_back({v, v + 1, v + 2});
    for (const Point<Part>& p : {a, b, c}) raw.bounds = grown(raw.bounds, p);
  }
  return raw;
}

bool has_axis_field(const PlanOptions& o) {
  return o.axis.mode != AxisMode::kFree && o.axis.mode != AxisMode::kIndexed;
}

/// Where the pattern follows the surface and nothing may raise the tool off it.
bool means_contact(const PlanOptions& o) {
  return o.pattern.kind != PatternKind::kRough && o.smoothing == 0.0 &&
         o.shank.reaction != Reaction::kRetract && o.holder.reaction != Reaction::kRetract;
}

class Judge {
 public:
  Judge(const Job& job, const Stl& stl, const CheckedMesh& part, const Plan& planned, const JointPath& joints)
      : job_(job),
        options_(job.plan),
        stl_(stl),
        part_(part),
        planned_(planned),
        path_(executed(job, planned.path, joints)),
        growth_{options_.allowance, options_.radial_stock, options_.axial_stock},
        contact_(means_contact(options_)),
        in_contact_(options_.tolerance + left_at_taper_edge(options_)) {}

  Verdict run() {
    proof_against(part_, contact_);
    if (!part_.defects.empty()) proof_against(as_read(stl_, part_), false);
    look_inside();
    look_at_fixtures();
    look_for_stock();
    if (verdict_.findings.empty()) look_for_uncut();
    return std::move(verdict_);
  }

 private:
  void finding(const char* kind, double value, const std::string& where) {
    char text[256];
    std::snprintf(text, sizeof text, "%s %.4f mm (tolerance %g) at ", kind, value, options_.tolerance);
    verdict_.findings.push_back(text + where);
  }

  void in_part(const CheckedMesh& mesh, double depth) {
    if (&mesh == &part_) verdict_.in_part = std::max(verdict_.in_part, depth);
  }

  void proof_against(const CheckedMesh& mesh, bool contact) {
    if (!has_axis_field(options_)) {
      // The contact of a fixed direction is judged as that of the mode fixed.
      const bool is_indexed = options_.axis.mode == AxisMode::kIndexed;
      if (contact && is_indexed) fixed_contact(mesh);
      return free_proof(mesh, contact && !is_indexed);
    }
    const double tolerance = contact ? options_.tolerance : sim::kInfinity;
    PathProof proof(options_.axis, options_.pattern.along, options_.cutter, tolerance, mesh, path_, growth_);
    const PatternKind kind = options_.pattern.kind;
    if (kind == PatternKind::kZLevel || kind == PatternKind::kSplit)
      proof.let_sides_touch(options_.cutter, growth_);
    const Measured m = proof.measure(1);
    verdict_.poses += m.poses + m.rapid_poses;
    verdict_.gouge = std::max(verdict_.gouge, m.gouge);
    verdict_.rapid = std::max(verdict_.rapid, m.rapid_overlap);
    in_part(mesh, std::max(m.gouge, m.rapid_overlap));
    if (m.gouge > options_.tolerance) finding("gouge", m.gouge, pasteable(m.gouge_at));
    if (m.rapid_overlap > options_.tolerance) finding("rapid", m.rapid_overlap, pasteable(m.rapid_at));
    // A tool that leans keeps its clearances as one whose axis is free.
    if (may_lean(options_) && &mesh == &part_) free_proof(mesh, false);
    if (!contact) return;
    verdict_.contact = m.contact;
    if (m.contact > in_contact_) finding("contact", m.contact, pasteable(m.contact_at));
  }

  /// Each run of one direction on its own. Joins between pieces may cross what the stock leaves room for.
  void fixed_contact(const CheckedMesh& mesh) {
    if (options_.radial_stock > 0.0 || options_.axial_stock > 0.0) return;
    std::size_t from = 0;
    for (std::size_t i = 1; i <= path_.moves.size(); ++i) {
      if (i < path_.moves.size() &&
          angle_between(path_.moves[i].pose.axis, path_.moves[from].pose.axis) < kSameDirection)
        continue;
      ToolPath run = path_;
      run.moves.assign(path_.moves.begin() + static_cast<std::ptrdiff_t>(from),
                       path_.moves.begin() + static_cast<std::ptrdiff_t>(i));
      AxisFrame frame;
      frame.n = run.moves.front().pose.axis;
      frame.t = normalized(cross(frame.n, std::abs(frame.n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
      const Measured m =
          PathProof(frame, Along::kX, options_.cutter, options_.tolerance, mesh, run, growth_).measure(1);
      verdict_.contact = std::max(verdict_.contact, m.contact);
      if (m.contact > in_contact_) finding("contact", m.contact, pasteable(m.contact_at));
      from = i;
    }
  }

  void free_proof(const CheckedMesh& mesh, bool contact) {
    const sim::PartDistance distances(mesh.mesh);
    const std::array clearance{0.0, options_.shank.clearance, options_.holder.clearance};
    const ToolProof proof(distances, mesh.bounds, options_.cutter, options_.tolerance, clearance, growth_);
    const ToolFindings f = proof.measure(path_, 0.25 * options_.cutter.diameter);
    verdict_.poses += f.cut_poses + f.link_poses;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string tool = std::string(sim::kToolPartNames[i]);
      verdict_.gouge = std::max(verdict_.gouge, f.cut[i].value);
      verdict_.rapid = std::max(verdict_.rapid, f.link[i].value);
      in_part(mesh, std::max(f.cut[i].value, f.link[i].value) - clearance[i]);
      if (f.cut[i].value > options_.tolerance)
        finding(("gouge by " + tool).c_str(), f.cut[i].value, pasteable(f.cut[i].at));
      if (f.link[i].value > options_.tolerance)
        finding(("link by " + tool).c_str(), f.link[i].value, pasteable(f.link[i].at));
    }
    if (!contact) return;
    verdict_.contact = f.contact.value;
    if (f.contact.value > in_contact_) finding("contact", f.contact.value, pasteable(f.contact.at));
  }

  /// No facet cuts a tool that is wholly inside, so that its clearances show nothing.
  void look_inside() {
    if (part_.sides != Sides::kOutward) return;
    const sim::PartDistance distances(part_.mesh);
    const std::size_t stride = 1 + path_.moves.size() / kBuriedLooks;
    for (std::size_t i = 0; i < path_.moves.size(); i += stride) {
      const Pose& pose = path_.moves[i].pose;
      const Point<Part> centre = pose.tip + pose.axis * (0.5 * options_.cutter.diameter);
      if (distances.winding_number(centre) < 0.5) continue;
      const double depth = distances.nearest(centre).value;
      if (depth > options_.tolerance) return finding("buried", depth, pasteable(pose));
    }
  }

  /// Cutter, shank and holder keep off fixtures, and faces that are not to be touched, on all moves; off
  /// these only as seen from outside.
  void look_at_fixtures() {
    if (!options_.fixtures) return;
    const Mesh& mesh = options_.fixtures->mesh;
    const sim::PartDistance distances(mesh);
    const sim::ToolSolid tool(options_.cutter, {});
    const std::array room{options_.fixture_room.cutter, options_.fixture_room.shank,
                          options_.fixture_room.holder};
    for (const Move& move : path_.moves) {
      for (std::size_t i = 0; i < room.size(); ++i) {
        const sim::Hit hit = tool.clearance(distances, move.pose, sim::kToolParts[i], room[i]);
        if (hit.facet == kNoFacet || room[i] - hit.value <= options_.tolerance) continue;
        const auto& f = mesh.facets[hit.facet];
        const Point<Part> a = mesh.vertices[f[0]];
        const Vec3 normal = cross(mesh.vertices[f[1]] - a, mesh.vertices[f[2]] - a);
        const Vec3 off = move.pose.tip + move.pose.axis * options_.cutter.nose_radius() - a;
        const bool is_face =
            options_.fixtures->names[mesh.source[hit.facet]].find("avoid_faces") != std::string::npos;
        if (is_face && dot(normal, off) < 0.0) continue;
        finding(("by " + options_.fixtures->names[mesh.source[hit.facet]] + ", of " +
                 std::string(sim::kToolPartNames[i]) + (move.kind == MoveKind::kRapid ? " on a rapid," : ","))
                    .c_str(),
                room[i] - hit.value, pasteable(move.pose));
        return;
      }
    }
  }

  void look_for_stock() {
    if (!StockJudge::can_judge(job_)) return;
    const StockJudge::Found found = StockJudge(job_, part_, path_).look(kRapids);
    verdict_.stock_places = found.places;
    if (found.pose)
      finding("rapid in stock", found.depth, pasteable(*found.pose) + ", place " + to_string(found.at));
  }

  /// What is left out is told: then it is no finding.
  bool is_told() const {
    return std::any_of(
        planned_.report.warnings.begin(), planned_.report.warnings.end(), [](const std::string& w) {
          return w.find("left out") != std::string::npos || w.find("too near") != std::string::npos;
        });
  }

  void look_for_uncut() {
    if (!contact_ || is_told() || !CoverJudge::can_judge(options_) || path_.moves.size() >= kMostMoves)
      return;
    const CoverJudge judge(options_, part_, planned_, path_, growth_);
    const CoverJudge::Found found = judge.look(kSurfacePoints);
    verdict_.surface_points = found.points, verdict_.left = std::max(0.0, found.excess);
    if (found.excess > options_.tolerance)
      finding("uncut", found.excess, to_string(found.at) + ", tool " + pasteable(found.seat));
  }

  const Job& job_;
  const PlanOptions& options_;
  const Stl& stl_;
  const CheckedMesh& part_;
  const Plan& planned_;
  ToolPath path_;
  sim::Growth growth_;
  bool contact_;
  double in_contact_;  ///< nearer than this the tool counts as in contact, mm
  Verdict verdict_;
};

}  // namespace

Verdict judge(const Job& job, const Stl& stl, const CheckedMesh& part, const Plan& planned,
              const JointPath& joints) {
  return Judge(job, stl, part, planned, joints).run();
}

}  // namespace tiltfeed::attack
