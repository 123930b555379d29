// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
// The engine's large functions, for programs of many units (base/once.hpp).
#define PALPATE_COMPILED_HERE
#include "engine.hpp"
