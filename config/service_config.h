#pragma once
// The file of `tiltfeed serve --config F`: one machine, its wire, where its jobs lie. Every key:
// config/service.yaml.

#include <string>

#include "config/machine_profile.h"

namespace tiltfeed::config {

struct ServiceConfig {
  std::string path;
  MachineProfile machine;
  std::string link;           ///< LINK text; the profile's default where the file names none
  std::string spool, socket;  ///< folder; file
  std::string watch;          ///< folder whose programs (*.nc) are submitted; empty: none
};

/// Relative paths start at the file's folder. Errors: kInput as file:line:column, kIo.
Result<ServiceConfig> load_service_config(const std::string& path);
Result<ServiceConfig> parse_service_config(const std::string& text, const std::string& path);

}  // namespace tiltfeed::config
