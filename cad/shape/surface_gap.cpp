#include "cad/shape/surface_gap.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRepLProp_SLProps.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

namespace tiltfeed::cad {
namespace {

constexpr int kSearchSteps = 8;
constexpr double kStill = 1e-9;        // mm: a step that changes nothing
constexpr double kNoSlope = 1e-14;     // mm^2: a direction of the parameters that does not move the place
constexpr double kNormalKnown = 1e-9;  // of SLProps, mm

/// In the surface's own frame: along its axis, and from it.
struct Round {
  double along = 0.0, from = 0.0;
};
Round round_of(const gp_Ax3& frame, const gp_Pnt& p) {
  const gp_Vec to(frame.Location(), p);
  const double along = to.Dot(gp_Vec(frame.Direction()));
  return {along, to.Crossed(gp_Vec(frame.Direction())).Magnitude()};
}

}  // namespace

struct SurfaceGap::State {
  BRepAdaptor_Surface surface;
};

SurfaceGap::SurfaceGap(const TopoDS_Face& face) : state_(new State{BRepAdaptor_Surface(face, true)}) {}
SurfaceGap::~SurfaceGap() = default;

double SurfaceGap::operator()(Point<Part> at, double u, double v) const {
  const BRepAdaptor_Surface& s = state_->surface;
  const gp_Pnt p(at.x, at.y, at.z);
  switch (s.GetType()) {
    case GeomAbs_Plane:
      return s.Plane().Distance(p);
    case GeomAbs_Cylinder:
      return std::abs(round_of(s.Cylinder().Position(), p).from - s.Cylinder().Radius());
    case GeomAbs_Sphere:
      return std::abs(p.Distance(s.Sphere().Location()) - s.Sphere().Radius());
    case GeomAbs_Torus: {
      const Round r = round_of(s.Torus().Position(), p);
      const auto to_tube = [&](double from) {
        return std::abs(std::hypot(from - s.Torus().MajorRadius(), r.along) - s.Torus().MinorRadius());
      };
      // Where the tube is wider than its circle, what is beyond the axis comes through.
      return std::min(to_tube(r.from), to_tube(-r.from));
    }
    case GeomAbs_Cone: {
      const Round r = round_of(s.Cone().Position(), p);
      const double a = s.Cone().SemiAngle();
      const auto to_line = [&](double from) {
        return std::abs((from - s.Cone().RefRadius()) * std::cos(a) - r.along * std::sin(a));
      };
      // Beyond the tip the axis has the cone's other half on its other side.
      return std::min(to_line(r.from), to_line(-r.from));
    }
    default:
      break;
  }
  // Gauss-Newton for the nearest place; at a pole one parameter does nothing and is left alone.
  double best = s.Value(u, v).Distance(p);
  for (int i = 0; i < kSearchSteps; ++i) {
    gp_Pnt q;
    gp_Vec du, dv;
    s.D1(u, v, q, du, dv);
    const gp_Vec to(q, p);
    best = std::min(best, to.Magnitude());
    const double a = du.SquareMagnitude(), b = du.Dot(dv), c = dv.SquareMagnitude();
    const double g = to.Dot(du), h = to.Dot(dv), det = a * c - b * b;
    double step_u = 0.0, step_v = 0.0;
    if (det > kNoSlope * (a * c) && a > kNoSlope && c > kNoSlope)
      step_u = (g * c - h * b) / det, step_v = (h * a - g * b) / det;
    else if (a > kNoSlope && a >= c)
      step_u = g / a;
    else if (c > kNoSlope)
      step_v = h / c;
    if (!s.IsUPeriodic()) step_u = std::clamp(u + step_u, s.FirstUParameter(), s.LastUParameter()) - u;
    if (!s.IsVPeriodic()) step_v = std::clamp(v + step_v, s.FirstVParameter(), s.LastVParameter()) - v;
    u += step_u, v += step_v;
    if ((du * step_u + dv * step_v).Magnitude() < kStill) break;
  }
  return std::min(best, s.Value(u, v).Distance(p));
}

Vec3 SurfaceGap::normal(double u, double v) const {
  BRepLProp_SLProps properties(state_->surface, u, v, 1, kNormalKnown);
  if (!properties.IsNormalDefined()) return {};
  const gp_Dir n = properties.Normal();
  return {n.X(), n.Y(), n.Z()};
}

std::string SurfaceGap::kind() const {
  switch (state_->surface.GetType()) {
    case GeomAbs_Plane:
      return "plane";
    case GeomAbs_Cylinder:
      return "cylinder";
    case GeomAbs_Cone:
      return "cone";
    case GeomAbs_Sphere:
      return "sphere";
    case GeomAbs_Torus:
      return "torus";
    case GeomAbs_BezierSurface:
    case GeomAbs_BSplineSurface:
      return "spline";
    case GeomAbs_SurfaceOfRevolution:
      return "surface of revolution";
    case GeomAbs_SurfaceOfExtrusion:
      return "surface of extrusion";
    case GeomAbs_OffsetSurface:
      return "offset surface";
    default:
      return "surface";
  }
}

}  // namespace tiltfeed::cad
