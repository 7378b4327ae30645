#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/doctor/doctor.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"
#include "daemon/service/spool.h"

namespace tiltfeed::daemon {

namespace {

namespace fs = std::filesystem;
constexpr double kGigabyte = 1e9;
/// What one submission of the largest size takes in the spool, bytes.
constexpr std::uint64_t kRoom = kMaxProgramBytes + kMaxPartBytes + kMaxJobBytes;

Finding programs(const Host& host, const std::string& version) {
  std::string beside;
  for (const char* const name : {"tiltfeed-sim", "tiltfeed-desk", "tiltfeed-cad"}) {
    const std::string file = host.programs + "/" + name;
    if (name != std::string("tiltfeed-sim") && ::access(file.c_str(), F_OK) != 0) continue;
    const std::string text = output_of(file, {"--version"}), said = text.substr(0, text.find('\n'));
    if (said != name + (" " + version))
      return {Verdict::kToDo, "versions",
              file + (said.empty() ? " does not start" : " is \"" + said + "\"") + ", and tiltfeed is " +
                  version + ": install packages of one version"};
    beside += std::string(", ") + name;
  }
  return {Verdict::kGood, "versions", version + ": tiltfeed" + beside};
}

Finding replaced(const Host& host) {
  for (const HostProcess& process : processes(host))
    if (process.program.ends_with("/tiltfeed (deleted)"))
      return {
          Verdict::kToDo, "running",
          "process " + std::to_string(process.pid) +
              " runs a version that was replaced since: restart its service when no job is on the machine"};
  return {Verdict::kGood, "running", "no process of a version that was replaced"};
}

Finding clock_kept(const Host& host) {
  if (host.clock.synchronised) return {Verdict::kGood, "clock", "kept by the network's time"};
  return {Verdict::kToDo, "clock",
          "not synchronised, so the times in logs and journals are a guess: apt install systemd-timesyncd, "
          "timedatectl set-ntp true"};
}

/// The folder itself, or the nearest one above it that is there.
std::string nearest(const std::string& folder) {
  fs::path at(folder);
  std::error_code error;
  while (!fs::exists(at, error) && at != at.parent_path()) at = at.parent_path();
  return at.empty() ? "." : at.string();
}

/// Where the unit of the configuration /etc/tiltfeed/NAME.yaml lets the service write; empty: no unit's file.
std::string unit_name(const std::string& config) {
  const fs::path path(config);
  return path.parent_path() == "/etc/tiltfeed" ? path.stem().string() : "";
}

bool below(const std::string& path, const std::string& folder) {
  return path == folder || path.starts_with(folder + "/");
}

Finding folder(const Host& host, const char* what, const std::string& path, const std::string& unit_folder) {
  if (!unit_folder.empty() && !below(path, unit_folder))
    return {Verdict::kToDo, what,
            path + ": the unit lets the service write below " + unit_folder +
                " only; move it there, or systemctl edit the unit: ReadWritePaths=" + path};
  const std::string there = nearest(host.root + path);
  struct stat file {};
  if (::stat(there.c_str(), &file) != 0) return {Verdict::kToDo, what, there + ": " + std::strerror(errno)};
  if (!S_ISDIR(file.st_mode)) return {Verdict::kToDo, what, there + " is no folder"};
  const bool is_there = there == host.root + path;
  if (!is_there && !unit_folder.empty())
    return {Verdict::kGood, what, path + " is not there yet; systemd makes it for the unit"};
  if (!host.asker.may(file, R_OK | W_OK | X_OK))
    return {Verdict::kToDo, what,
            there + ": " + host.asker.name + " may not write there: " +
                (is_there ? "chown -R " + host.asker.name + " " + there
                          : "install -d -o " + host.asker.name + " " + path)};
  struct statvfs disk {};
  if (::statvfs(there.c_str(), &disk) == 0 && (disk.f_flag & ST_RDONLY) != 0)
    return {Verdict::kToDo, what, there + " is mounted read-only: mount it for writing"};
  return {Verdict::kGood, what, path + (is_there ? "" : " is not there yet and can be made")};
}

Finding room(const Host& host, const std::string& spool) {
  struct statvfs disk {};
  const std::string there = nearest(host.root + spool);
  if (::statvfs(there.c_str(), &disk) != 0)
    return {Verdict::kToDo, "disk", there + ": " + std::strerror(errno)};
  const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  char text[32];
  std::snprintf(text, sizeof text, "%.1f GB free at ", static_cast<double>(free) / kGigabyte);
  const bool full = disk.f_files > 0 && disk.f_favail == 0;
  if (free >= kRoom && !full) return {Verdict::kGood, "disk", text + spool};
  return {Verdict::kToDo, "disk",
          text + spool + (full ? ", and no file can be made" : "") +
              ": a submission may take 2.7 GB; tiltfeed remove jobs that are done, or move the spool"};
}

Finding service(const config::ServiceConfig& config) {
  ApiRequest request;
  const Result<std::string> line = ask_service(config.socket, write_request(request), {}, kShortPatience);
  if (!line && line.error().code == Code::kLink)
    return {Verdict::kToDo, "service", line.error().message + ", though it is there: restart it"};
  if (!line)
    return {Verdict::kNotAsked, "service",
            "none answers at " + config.socket + ": systemctl start tiltfeed@NAME, or see journalctl"};
  const auto answer = nlohmann::json::parse(*line, nullptr, false);
  if (!answer.is_object() || !answer.value("ok", false))
    return {Verdict::kToDo, "service", config.socket + " gives an answer that is not understood: restart it"};
  return {Verdict::kGood, "service",
          answer.value("machine", "") + " at " + answer.value("link", "") + " answers at " + config.socket};
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  return verdict == Verdict::kGood ? "good" : verdict == Verdict::kToDo ? "to do" : "not asked";
}

Findings examine_host(const Host& host, const std::string& version) {
  return {programs(host, version), replaced(host), clock_kept(host)};
}

Findings examine_places(const Host& host, const config::ServiceConfig& config) {
  const std::string unit = unit_name(config.path);
  const std::string state = unit.empty() ? "" : "/var/lib/tiltfeed/" + unit,
                    runtime = unit.empty() ? "" : "/run/tiltfeed/" + unit;
  Findings found = {folder(host, "spool", config.spool, state), room(host, config.spool),
                    folder(host, "socket", fs::path(config.socket).parent_path(), runtime)};
  if (!config.watch.empty()) found.push_back(folder(host, "watch", config.watch, state));
  found.push_back(service(config));
  return found;
}

}  // namespace tiltfeed::daemon
