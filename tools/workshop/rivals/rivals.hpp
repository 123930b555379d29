#pragma once

#include "tools/workshop/rivals/neural.hpp"
#include "tools/workshop/rivals/rival.hpp"
#include "tools/workshop/rivals/rivals_table.hpp"

namespace palpate::tools {

/// Every rival there is, Palpate last.
inline constexpr RivalRow kRivals[] = {
    {"proxy", "a point on the surface, one spring, a friction cone", prepare_proxy},
    {"proxy-curves", "the same with the press of the nearest test point", prepare_proxy_on_curves},
    {"separable", "the paper's separable law", prepare_separable},
    {"green", "Green's functions of the surface's nodes, a ball by complementarity", prepare_green},
    {"corotational", "coarse bodies of linear tetrahedra, solved at every tick",
     prepare_corotational},
    {"explicit", "the same meshes, total-Lagrangian with central differences", prepare_explicit},
    {"bullet", "Bullet's deformable bodies (Debian: libbullet-dev, when configured)",
     prepare_bullet},
    {"mujoco", "MuJoCo's flex in Node (npm: @mujoco/mujoco; --packages DIR)", prepare_mujoco},
    {"neural", "a small neural network behind a proxy", prepare_neural},
    {"palpate", "Palpate by number of test points", prepare_palpate},
};

/// Prepares a row's rivals, measures each for budget_s and puts it into the table; one that does
/// not come to rest is left out of it by name.
void measure_part(const RivalRow& row, const RivalBody& body, double budget_s, RivalsTable& table);

}  // namespace palpate::tools
