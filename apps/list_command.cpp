// kilotouch list: every backend of every family, and why one is unavailable.
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/words.hpp"
#include "collision/broad/triangle_index.hpp"
#include "core/global/integrator.hpp"
#include "haptics/device/device_backends.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/link/links.hpp"
#include "haptics/refresh/reducer_choice.hpp"
#include "haptics/tick/haptic_method.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

struct Family {
  std::string name, key;
  std::vector<BackendInfo> backends;
};

std::vector<Family> all_families() {
  return {{"models", "object.model.type", model_backends()},
          {"materials", "object.model.material", material_backends()},
          {"tetrahedralizers", "object.tetrahedralize.backend", tetrahedralizers()},
          {"global integrators", "global.integrator", integrator_backends()},
          {"reducers", "local.reducer", reducer_names()},
          {"collision", "collision.backend", triangle_index_backends()},
          {"contact surfaces", "contact.surface", contact_surface_backends()},
          {"methods", "local.method", haptic_method_backends()},
          {"contact laws", "contact.law", contact_solver_backends()},
          {"devices", "tool.path", device_backends()},
          {"links", "link.type", link_backends()}};
}

void list(const std::string& json_file) {
  nlohmann::ordered_json json;
  for (const Family& family : all_families()) {
    std::cout << family.name << "  (" << family.key << ")\n";
    for (const BackendInfo& b : family.backends) {
      std::cout << "  " << b.name << std::string(b.name.size() < 18 ? 18 - b.name.size() : 1, ' ') << b.what;
      if (!b.available) std::cout << "  [not in this build: configure with -D" << b.option << "=ON]";
      std::cout << '\n';
      json[family.key].push_back(
          {{"name", b.name}, {"what", b.what}, {"available", b.available}, {"option", b.option}});
    }
  }
  write_json(json_file, json_text(json, 2) + "\n");
}

}  // namespace

void add_list_command(CLI::App& app, int&) {
  auto* command = app.add_subcommand("list", "every backend of every family, and the reason for a missing one");
  auto file = std::make_shared<std::string>();
  add_json_option(*command, *file, "the table");
  command->footer("Example:\n  kilotouch list");
  command->callback([file] { list(*file); });
}

}  // namespace kt
