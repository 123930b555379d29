// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The engine is header-only: whoever includes it compiles it, in 10 seconds. A program of many
// units can compile its large functions once: PALPATE_COMPILED_ONCE is defined for every unit, and
// one source defines PALPATE_COMPILED_HERE before it includes engine.hpp (once.cpp). A unit in
// which ticks must not cost a call more leaves PALPATE_COMPILED_ONCE undefined.

#include "rounding.hpp"

#if !defined(PALPATE_COMPILED_ONCE)
#define PALPATE_HAS_BODIES 1
#define PALPATE_ONCE inline
#elif defined(PALPATE_COMPILED_HERE)
#define PALPATE_HAS_BODIES 1
#define PALPATE_ONCE
#else
#define PALPATE_HAS_BODIES 0
#define PALPATE_ONCE
#endif
