#include "config/part_reading.h"

#include "config/cad_process.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/part_file/file_kind.h"
#include "pathgen/part_file/three_mf.h"

namespace tiltfeed::config {

Result<pathgen::PartModel> read_part_file(const PartRequest& request, const pathgen::ReportShare& report) {
  const pathgen::PartFormat format = pathgen::format_of_file(request.path);
  if (format == pathgen::PartFormat::kMesh) {
    auto stl = pathgen::read_stl(request.path, request.unit_mm);
    if (!stl) return tl::unexpected(stl.error());
    pathgen::PartModel model;
    model.mesh = std::move(*stl);
    if (auto kept = pathgen::keep_bodies(model, request.bodies, request.path); !kept)
      return tl::unexpected(kept.error());
    return model;
  }
  if (request.unit_mm != 1.0)
    return fail(Code::kInput, request.path + ": a unit of " + number_text(request.unit_mm, 7) +
                                  " mm is stated for it, and the file states its own; remove part.unit");
  if (format == pathgen::PartFormat::kThreeMf) {
    auto model = pathgen::read_three_mf(request.path);
    if (!model) return model;
    if (auto kept = pathgen::keep_bodies(*model, request.bodies, request.path); !kept)
      return tl::unexpected(kept.error());
    return model;
  }
  return run_cad(request.path, request.bodies, request.deviation, report);
}

Result<pathgen::PartModel> read_part_model(const Job& job, const pathgen::ReportShare& report) {
  return read_part_file({job.stl_path, job.stl_unit_mm, job.bodies, job.tessellation}, report);
}

Result<pathgen::CheckedMesh> check_part(const Job& job, pathgen::PartModel& model,
                                        const pathgen::ReportShare& report) {
  auto checked = pathgen::check_mesh(model.mesh, {ToleranceBudget(job.plan.tolerance).repair()}, report);
  if (checked && !model.format.empty())
    checked->warnings.insert(checked->warnings.begin(), model.mesh.warnings.begin(),
                             model.mesh.warnings.end());
  model.mesh = pathgen::Stl{};  // gives its memory back; facets = {} would keep it
  return checked;
}

Result<pathgen::CheckedMesh> read_part(const Job& job, const pathgen::ReportShare& report) {
  auto model = read_part_model(job, report);
  if (!model) return tl::unexpected(model.error());
  return check_part(job, *model, report);
}

Result<const pathgen::CheckedMesh*> PartsByTolerance::of(const Job& job, const pathgen::ReportShare& report) {
  const double tolerance = job.plan.tolerance;
  if (const auto known = parts_.find(tolerance); known != parts_.end()) return &known->second.mesh;
  auto model = read_part_model(job, report);
  if (!model) return tl::unexpected(model.error());
  auto part = check_part(job, *model, report);
  if (!part) return tl::unexpected(part.error());
  return &parts_.emplace(tolerance, Part{std::move(*part), std::move(*model)}).first->second.mesh;
}

}  // namespace tiltfeed::config
