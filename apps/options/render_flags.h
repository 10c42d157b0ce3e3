#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "relief/rendering/picture_camera.h"
#include "relief/rendering/render_mesh.h"

namespace relief {

/// What `relief render` is asked for.
struct RenderFlags {
  std::vector<rendering::RenderStyle> styles{rendering::RenderStyle::kShaded};
  std::vector<rendering::ViewingDirection>
      directions;  ///< Empty: six in a sheet, else the default.
  rendering::FramingOptions framing;
  bool has_size = false;  ///< Whether the size of `framing` was given.
  rendering::RenderOptions options;
  std::optional<rendering::ShadingNormals> normals;  ///< Unset: what fits the input.
  std::filesystem::path truth;
  std::vector<std::string> only;  ///< Names of views; empty: all.
  int turntable = 0;              ///< How many pictures round the object; 0: none.
  bool contact_sheet = false;
  bool no_legend = false;

  bool shows(rendering::RenderStyle style) const;
};

/// Binds the flags of `relief render` to the fields, which hold the defaults.
void add_render_flags(CLI::App& command, RenderFlags& flags);

}  // namespace relief
