#include "sim/collision/machine_view.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "config/output_file.h"
#include "sim/collision/machine_line.h"
#include "sim/collision/solid_mesh.h"

namespace tiltfeed::sim {
namespace {

using nlohmann::json;

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

json numbers(const Placement& p) {
  json rows = json::array();
  for (const Vec3 unit : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
    rows.push_back(numbers(p.rotation * unit));
  return {{"columns", rows}, {"shift", numbers(p.shift)}};
}

class View {
 public:
  explicit View(const config::Job& job) : line_(job.machine, job.setup) {
    head_ = {{"machine", job.machine.model.name}, {"part", numbers(line_.part())},
             {"tip", numbers(line_.tip().shift)}, {"bed", line_.link(config::BodyLink::kBed)},
             {"joints", json::array()},           {"bodies", json::array()}};
    for (const LineJoint& joint : line_.joints())
      head_["joints"].push_back({{"axis", joint.axis},
                                 {"turns", joint.turns()},
                                 {"point", numbers(joint.point)},
                                 {"direction", numbers(joint.direction)},
                                 {"factor", joint.factor},
                                 {"home", joint.home}});
  }

  Result<void> add_bodies(const config::MachineProfile& machine) {
    for (const config::MachineBody& body : machine.solid.bodies) {
      auto mesh = mesh_of(body.shape);
      if (!mesh)
        return fail(mesh.error().code, machine.path + ": body " + body.name + ": " + mesh.error().message);
      mesh->place({}, line_.origin(body.link));
      add(body.name, body.colour, line_.link(body.link), false, *mesh);
    }
    return {};
  }

  Result<void> add_fixtures(const config::Job& job) {
    for (const config::Fixture& fixture : job.fixtures) {
      auto mesh = mesh_of(fixture.shape);
      if (!mesh)
        return fail(mesh.error().code, job.path + ": fixture " + fixture.name + ": " + mesh.error().message);
      fixture.on_part ? mesh->place(line_.part().rotation, line_.part().shift)
                      : mesh->place({}, line_.table());
      add(fixture.name, fixture.colour, line_.work(), true, *mesh);
    }
    return {};
  }

  std::string bytes() const {
    std::string head = head_.dump(-1, ' ', true, json::error_handler_t::replace);
    head.resize((head.size() + 3) / 4 * 4, ' ');
    const auto length = static_cast<std::uint32_t>(head.size());
    std::string all(sizeof length, '\0');
    std::memcpy(all.data(), &length, sizeof length);
    all += head;
    all.append(reinterpret_cast<const char*>(corners_.data()), corners_.size() * sizeof(float));
    return all;
  }

 private:
  void add(const std::string& name, const std::string& colour, int link, bool fixture,
           const SolidMesh& mesh) {
    head_["bodies"].push_back({{"name", name},
                               {"colour", colour},
                               {"link", link},
                               {"fixture", fixture},
                               {"facets", mesh.facets.size()}});
    for (const auto& facet : mesh.facets)
      for (const std::uint32_t corner : facet)
        for (const double x : {mesh.vertices[corner].x, mesh.vertices[corner].y, mesh.vertices[corner].z})
          corners_.push_back(static_cast<float>(x));
  }

  MachineLine line_;
  json head_;
  std::vector<float> corners_;
};

}  // namespace

Result<std::string> machine_view(const config::Job& job) {
  View view(job);
  if (const auto added = view.add_bodies(job.machine); !added) return tl::unexpected(added.error());
  if (const auto added = view.add_fixtures(job); !added) return tl::unexpected(added.error());
  return view.bytes();
}

Result<void> machine_view_command(const MachineViewOptions& options) {
  // Machine, set-up and fixtures are those of all operations.
  const auto jobs = config::load_operations(options.job, {.machine = options.machine});
  if (!jobs) return tl::unexpected(jobs.error());
  const config::Job& job = jobs->front();
  const auto fits =
      config::check_outputs({{"--out", options.out}}, {{"JOB", options.job}, {"machine", job.machine.path}});
  if (!fits) return fits;
  const auto view = machine_view(job);
  if (!view) return tl::unexpected(view.error());
  return config::write_file(options.out, *view);
}

}  // namespace tiltfeed::sim
