/* Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT */
#ifndef PALPATE_H
#define PALPATE_H

/* Palpate's engine for C, and for every language that calls C.

   An asset (*.palp) holds force-deflection curves on every node of a soft body. A tool's pose goes
   in at every tick, a force comes out. This page is the manual.

     if (palpate_header_fits() != PALPATE_OK) ...                    once, before anything else
     palpate_asset asset;
     if (palpate_open(&asset, bytes, size) != PALPATE_OK) ...        once; checks every byte
     palpate_info info;
     palpate_describe(&asset, &info);
     palpate_contact contact;
     palpate_tool tool = palpate_ball(info.probe_radius_m);          the ball of the curves
     palpate_start(&contact, &tool);                                 once per tool
     palpate_input in = palpate_input_at(x, y, z, 0.001);            0.001 s since the tick before
     palpate_output out;
     palpate_tick(&asset, &contact, 1, &in, &out);                   every tick: out.force_on_tool_N

   Units are SI: metres, newtons, newton metres, joules, seconds. Coordinates are right-handed and
   those of the world in which both poses are; with the body's pose left at rest, the world is
   the body's own frame, that of the mesh it was made from.

   Real time. No function but palpate_open takes longer than its bound below. No function allocates,
   locks, waits, reads a clock, calls the system or throws; of the C library only sqrt, memcpy,
   memset and memcmp are used. Everything is allocated by the caller.
   Threads. An opened asset is never written: any number of threads and tools may share it. One
   contact belongs to one thread at a time. There are no globals.
   Determinism. The same bytes and inputs lead to the same bits with every compiler and optimization
   level on machines with IEEE doubles; palpate_open verifies it on the asset's own check path.
   Errors. A status other than PALPATE_OK always comes with zero force and torque, never a stale
   one.
   Version. PALPATE_ABI is raised when a structure or a meaning changes. */

#include <stddef.h>
#include <stdint.h>

/* On Windows a DLL is built with PALPATE_EXPORTS, and who links it may say PALPATE_DLL. */
#if defined(PALPATE_STATIC)
#define PALPATE_API
#elif defined(_WIN32)
#if defined(PALPATE_EXPORTS)
#define PALPATE_API __declspec(dllexport)
#elif defined(PALPATE_DLL)
#define PALPATE_API __declspec(dllimport)
#else
#define PALPATE_API
#endif
#elif !defined(__GNUC__)
#define PALPATE_API
#else
#define PALPATE_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
#define PALPATE_NOEXCEPT noexcept
extern "C" {
#else
#define PALPATE_NOEXCEPT
#endif

#define PALPATE_ABI 1

/* Results of calls. palpate_sentence() has a sentence for people on each. */
typedef int32_t palpate_status;
enum {
  PALPATE_OK = 0,
  /* A tick or a start was refused. */
  PALPATE_NULL_ARGUMENT = 1,    /* a pointer is null; nothing but *out was written */
  PALPATE_ASSET_NOT_OPEN = 2,   /* palpate_open was not called on it, or failed */
  PALPATE_NOT_STARTED = 3,      /* palpate_start was not called on the contact, or failed */
  PALPATE_TIP_NOT_FINITE = 4,   /* NaN or infinity where the tool is */
  PALPATE_TIP_TELEPORTED = 5,   /* farther than max_step_m in a tick; contact begins anew outside */
  PALPATE_CONTACT_FOREIGN = 6,  /* the contact was used with other bytes; it was reset */
  PALPATE_FORCE_NOT_FINITE = 7, /* overflow at absurd depths; the contact was reset */
  PALPATE_POSE_WRONG = 8,       /* not finite, or a quaternion whose length is off by 0.001 */
  PALPATE_TIME_STEP_WRONG = 9,  /* something reads dt_s, and it is not in range */
  PALPATE_TOOL_WRONG = 10,      /* a number of the tool is out of its range; palpate_tick: several
                                   balls, and the asset does not couple */
  PALPATE_NO_SHAPE = 11,        /* palpate_deform: the asset does not say how its surface moves */
  PALPATE_VERTICES_WRONG = 12,  /* palpate_deform: not all of these vertices exist */
  PALPATE_HEADER_WRONG = 13,    /* palpate_header_fits: the program has another library's header */
  PALPATE_BODY_WRONG = 14,  /* palpate_body_open: no body of this asset, which must be damaged */
  PALPATE_COUNT_WRONG = 15, /* not 1 to PALPATE_MAX_BALLS tools, or more balls between them */
  /* palpate_open refused the bytes. */
  PALPATE_BYTES_MISSING = 20,    /* null, or too few for a header */
  PALPATE_BYTES_MISALIGNED = 21, /* they do not begin at a multiple of 8 */
  PALPATE_NOT_AN_ASSET = 22,     /* they do not begin with PALP */
  PALPATE_OTHER_ENDIANNESS = 23,
  PALPATE_OTHER_VERSION = 24,
  PALPATE_SIZE_WRONG = 25,
  PALPATE_LAYOUT_WRONG = 26,   /* impossible counts or section offsets */
  PALPATE_CHECKSUM_WRONG = 27, /* changed or cut */
  PALPATE_CONTENT_WRONG = 28,  /* numbers, curves, triangles, normals or tree are impossible */
  PALPATE_REPLAY_DIFFERS = 29  /* this build of the engine has other bits than the exporter's */
};

enum { PALPATE_MAX_BALLS = 8 }; /* of one tool, and of all that are ticked together */

/* Storage that the engine fills; treat it as opaque. Static, on a stack or in an array: nothing is
   owned, nothing needs to be freed, and a plain copy is a copy. */
typedef struct palpate_asset {
  uint64_t storage[256];
} palpate_asset;
/* State of one tool on one body. A tick reads and writes what its balls need, 4 kB each. */
typedef struct palpate_contact {
  uint64_t storage[3968];
} palpate_contact;

/* Rotation, then translation: world = R(orientation) local + position_m. */
typedef struct palpate_pose {
  double position_m[3];
  double orientation[4]; /* unit quaternion w, x, y, z; q and -q are the same */
} palpate_pose;

/* A rigid tool: 1 to PALPATE_MAX_BALLS balls fixed to each other. A tip or a ball is one; a lying
   capsule, a finger, a grasper's jaw are several, each with a radius of its own. Several are for
   assets that couple (palpate_info.couples). The asset's curves were measured with a ball of
   palpate_info.probe_radius_m: for another radius, a cone or a rod open the asset with an indenter
   (palpate_indenter_open), for all balls in place of the asset or for one ball in `ball_asset`.
   Without that another radius changes where contact begins, not the curves, and is flagged
   PALPATE_FLAG_OTHER_RADIUS. What a turn of the tool drags along under its balls counts.
   The damper acts parallel to the curves: b(dz) = b min(1, dz / damper_depth_m) against the tool's
   motion along the contact's normal (damping_Ns_m) and across it (lateral_damping_Ns_m), shared
   among the balls. It never pulls the tool in. Its energy is damped_J. Last of all force and torque
   are brought up over ramp_s from the first tick on (passive only if nothing is pressed meanwhile)
   and held at or below max_force_N. A capped tool yields less as it is lifted than it took as it
   was pressed: cutting a force by its size would yield energy round a loop. Have the device's own
   clip behind it. Energies stay those of the whole force. palpate_tip() and palpate_ball() begin
   one; zero a tool that you fill yourself.
 */
typedef struct palpate_tool {
  int32_t balls;
  int32_t reserved_0;
  double centre_m[PALPATE_MAX_BALLS][3]; /* of each in the tool's frame; within 1000 */
  double radius_m[PALPATE_MAX_BALLS];    /* up to 1000. 0: a tip. On curves that were measured with
                                            a ball it is that ball's lowest point at first touch,
                                            and that ball does not turn */
  double damping_Ns_m;                   /* N s/m, 0 to 1e4; 0: none */
  double damper_depth_m;       /* depth at which it is whole; > 0 where there is damping */
  double lateral_damping_Ns_m; /* 0 to 1e4; 0: none */
  double max_force_N;          /* largest force of the device; 0: no cap */
  double ramp_s;               /* 0: none */
  const palpate_asset* ball_asset[PALPATE_MAX_BALLS]; /* the asset as each ball meets it, opened by
                                            palpate_indenter_open of the asset that is ticked; it
                                            must stay where it is. Null: as it is */
  double reserved[5];                                 /* 0; another number is refused */
} palpate_tool;

enum { PALPATE_MAX_PROFILE = 48 };

/* A tool's round end, standing along the surface's normal. Of a ball its radius; of a cone, a rod
   or any other the profile, too: f'(r) >= 0, the slope of its surface over the distance from its
   axis, never falling, linear between points [2 to PALPATE_MAX_PROFILE], from 0 at r = 0 on; beyond
   the last point stands a wall. `palpate inspect ASSET --tool SCENE` prints it. A tool's ball is
   then the one that it ends with: its radius round_end_m, its centre so far above the lowest point;
   of one that ends flat a tip. */
typedef struct palpate_indenter {
  double round_end_m; /* radius of the ball that it ends with; 0: it ends flat */
  int32_t points;     /* of the profile; 0: a ball */
  int32_t reserved_0; /* 0 */
  double r_m[PALPATE_MAX_PROFILE];
  double slope[PALPATE_MAX_PROFILE];
} palpate_indenter;

/* One tick's question. */
typedef struct palpate_input {
  palpate_pose tool;
  palpate_pose body;     /* identity for a body that rests */
  double dt_s;           /* since the previous tick, 1e-5 to 1e6; read by damper, ramp and a
                            body that relaxes */
  int32_t wants_tangent; /* nonzero: fill stiffness_N_m; a tick then takes several times as long */
  int32_t reserved[9];   /* 0 */
} palpate_input;

enum { PALPATE_AIR = 0, PALPATE_STICK = 1, PALPATE_SLIP = 2 };

/* Or-ed together in flags. */
enum {
  PALPATE_FLAG_UNFINISHED = 1,    /* the slip is longer than a tick may take; the next goes on */
  PALPATE_FLAG_BORDER = 2,        /* the contact point was at a border that held it */
  PALPATE_FLAG_HELD_BACK = 4,     /* a slip would have created energy: the force is lower for it */
  PALPATE_FLAG_TOO_DEEP = 8,      /* deeper than slides are well-conditioned for at this triangle */
  PALPATE_FLAG_FRICTIONLESS = 16, /* no lateral stiffness here: slides as if frictionless */
  PALPATE_FLAG_BLOCKED = 32,      /* the tool slips on beside a contact point that cannot follow */
  PALPATE_FLAG_OUTSIDE = 64,      /* not measured here: the body's mean curves, or none, and the
                                     rim where the measured ones pass into these */
  PALPATE_FLAG_EXTRAPOLATED =
      128,                    /* deeper than range_m: the curves go on along their last slope */
  PALPATE_FLAG_CAPPED = 256,  /* the force was brought down to max_force_N */
  PALPATE_FLAG_RAMP = 512,    /* the tool's ramp is not over */
  PALPATE_FLAG_INSIDE = 1024, /* in the air: a ball, its centre outside, stands in the surface, or
                                 a tip under it, and nothing answers until it is out or, having
                                 lifted off, sinks */
  PALPATE_FLAG_OTHER_RADIUS = 2048, /* the curves were measured with a ball of another radius: the
                                       force is off by as much as the radii differ */
  PALPATE_FLAG_CROWDED = 4096 /* the tool stands in another one. What they do to each other is then
                                 bounded and passive, but not measured */
};

/* Or-ed together in events, each at the one tick at which it happens. */
enum { PALPATE_TOUCHED = 1, PALPATE_RELEASED = 2 };

/* One tick's answer, in world coordinates. In the air, and with any status but PALPATE_OK, force,
   torque and stiffness are exactly zero and triangle is -1. Energies are sums since
   palpate_start. Of a tool of several balls force and torque are sums over them; contact_m,
   acts_at_m and normal are means, weighted by the force of each ball; triangle, weight, normal_m
   and lateral_m are those of the ball with the largest force. */
typedef struct palpate_output {
  double force_on_tool_N[3];   /* what a device displays; that on the body is its negative */
  double torque_on_tool_Nm[3]; /* of that force about the tool's position: it acts at the tip, or
                                  one radius from a ball's centre along the contact's normal */
  double contact_m[3];         /* the point of the resting surface that the tool holds on to */
  double normal[3];            /* unit, into the body, at that point */
  double weight[3];            /* its area coordinates in the triangle, sum 1 */
  double normal_m;             /* deflection along the normal, > 0 in contact */
  double lateral_m;            /* deflection across it, >= 0 */
  double stored_J;             /* elastic energy now */
  double dissipated_J;     /* by slips, less what they took; of rings while PALPATE_STICK, too */
  double refused_J;        /* that slips would have created, each joule once; see HELD_BACK */
  double damped_J;         /* by the damper */
  double stiffness_N_m[9]; /* row-major d(force on the body) / d(tool position), elastic part,
                              the tool not turning: exact for the branch taken, with the contact
                              point of a first touch held; zero unless wanted */
  int64_t refused_ticks;   /* ticks at which the guard acted */
  int32_t triangle;        /* of the surface; -1 in the air */
  int32_t state;           /* PALPATE_AIR, PALPATE_STICK or PALPATE_SLIP */
  uint32_t flags;          /* PALPATE_FLAG_... */
  palpate_status status;   /* what palpate_tick returned */
  double deflection_m[3];  /* from contact_m to acts_at_m */
  double acts_at_m[3];     /* where the force acts */
  double approach_m_s;     /* of the tick of a touch: into the body, along the normal */
  uint32_t events;         /* PALPATE_TOUCHED, PALPATE_RELEASED: the tool as a whole */
  int32_t touching;        /* balls in contact */
  uint32_t reserved[6];    /* 0 */
} palpate_output;

/* Description of an opened asset. */
typedef struct palpate_info {
  int32_t vertices, triangles;
  double max_step_m;     /* a tip moving farther in one tick has teleported */
  double probe_radius_m; /* of the probe the curves were measured with; 0 unknown or a point */
  double box_min_m[3], box_max_m[3]; /* of what can be touched, in the body's frame */
  double range_m;                    /* depth up to which the curves were fitted */
  uint64_t checksum;                 /* of the asset's bytes */
  const char* law;                   /* "rings", ...: the curve family; static */
  int32_t has_guard;                 /* slips may not create energy */
  int32_t has_shape;                 /* palpate_deform answers */
  int32_t relaxes;                   /* forces depend on time: every tick needs dt_s */
  int32_t softens;                   /* a body of it softens: palpate_body_start */
  int32_t couples;                   /* balls, and tools, move each other */
  int32_t visual_vertices;           /* of a mesh of one's own (palpate_place_visual); 0: none */
  const char* meta_json; /* error statement, scene; within the caller's bytes, NOT terminated */
  uint64_t meta_bytes;
} palpate_info;

/* The surface, within the caller's bytes: vertex v is at origin_m + vertex_m[3 v + 0 .. 2]. */
typedef struct palpate_mesh {
  int32_t vertices, triangles;
  double origin_m[3];
  const float* vertex_m;      /* 3 a vertex */
  const float* inward_normal; /* 3 a vertex, unit */
  const uint8_t* covered;     /* 1 a vertex: 1 measured, 2 the body's mean, 0 answers nothing */
  const int32_t* triangle;    /* 3 corners a triangle, counter-clockwise from outside */
  uint32_t reserved[8];       /* 0 */
} palpate_mesh;

/* Compares a program's PALPATE_ABI and its sizes of asset, contact, pose, tool, input, output, info
   and mesh [bytes, in this order] with the library's: PALPATE_OK, PALPATE_HEADER_WRONG or
   PALPATE_NULL_ARGUMENT. C and C++ call palpate_header_fits() below. */
PALPATE_API palpate_status palpate_sizes_fit(int32_t abi, const uint32_t bytes[8]) PALPATE_NOEXCEPT;

/* One sentence in English, never null, for any number. */
PALPATE_API const char* palpate_sentence(palpate_status status) PALPATE_NOEXCEPT;

/* Opens the asset in `bytes` [size], 8-byte aligned (those of malloc and file maps are), which must
   outlive it unchanged. Trusts nothing and is safe on hostile bytes. Not for the real-time thread:
   every byte is read once or twice, about 1 ms per 2 MB. On any fault *asset is closed. */
PALPATE_API palpate_status palpate_open(palpate_asset* asset, const void* bytes,
                                        uint64_t size) PALPATE_NOEXCEPT;

/* PALPATE_OK, PALPATE_NULL_ARGUMENT or PALPATE_ASSET_NOT_OPEN. */
PALPATE_API palpate_status palpate_describe(const palpate_asset* asset,
                                            palpate_info* info) PALPATE_NOEXCEPT;

/* PALPATE_OK, PALPATE_NULL_ARGUMENT or PALPATE_ASSET_NOT_OPEN. */
PALPATE_API palpate_status palpate_read_mesh(const palpate_asset* asset,
                                             palpate_mesh* mesh) PALPATE_NOEXCEPT;

/* A body that contacts damage (palpate_info.softens): the largest energies of its vertices, in
   memory of the caller's beside the asset. Any number of bodies may share an asset. palpate_tick on
   the asset itself is that of a body that nothing damages.

   palpate_body_bytes: how much memory, 8-byte aligned; 0 where the asset is not open or nothing
   damages its bodies. palpate_body_start: a new body in it; a body that is there already is healed.
   palpate_body_open: *opened is the asset with this body, to be used in place of the asset; ticks
   on it write to the memory, so contacts of one body belong to one thread.

   Any number of contacts may touch one body; each meets what the others did to it.

   The bytes are plain and may be copied at any time between ticks to save them, and put back: what
   is opened on them goes on from there, with the contacts that were saved with them; release others
   (palpate_release), and all contacts of a body that is healed. After a restart open them again;
   that checks them, and is safe on hostile bytes.

   PALPATE_OK, PALPATE_NULL_ARGUMENT, PALPATE_ASSET_NOT_OPEN or PALPATE_BODY_WRONG. */
PALPATE_API uint64_t palpate_body_bytes(const palpate_asset* asset) PALPATE_NOEXCEPT;
PALPATE_API palpate_status palpate_body_start(const palpate_asset* asset, void* body,
                                              uint64_t bytes) PALPATE_NOEXCEPT;
PALPATE_API palpate_status palpate_body_open(palpate_asset* opened, const palpate_asset* asset,
                                             void* body, uint64_t bytes) PALPATE_NOEXCEPT;

/* The asset as another indenter than its own ball meets it (docs/method-tools.md, section 30):
   tables in memory of the caller's, made once; a tick then costs what it costs. *opened is to be
   used in place of the asset, which must outlive it, or as palpate_tool.ball_asset; with a body of
   a softening asset, open the body first. Contacts are of one indenter: start them anew for
   another. palpate_indenter_bytes: how much memory, 8-byte aligned, some 20 to 100 kB; 0 where the
   asset is not open or was not measured with a ball. palpate_indenter_open: some milliseconds, not
   for the real-time thread. PALPATE_OK, PALPATE_NULL_ARGUMENT, PALPATE_ASSET_NOT_OPEN or
   PALPATE_TOOL_WRONG (numbers of the indenter, memory of another size, an asset of no ball). */
PALPATE_API uint64_t palpate_indenter_bytes(const palpate_asset* asset) PALPATE_NOEXCEPT;
PALPATE_API palpate_status palpate_indenter_open(palpate_asset* opened, const palpate_asset* asset,
                                                 const palpate_indenter* indenter, void* memory,
                                                 uint64_t bytes) PALPATE_NOEXCEPT;

/* Closes the asset; its bytes may go. Ticks on it are then refused. Null is allowed. */
PALPATE_API void palpate_close(palpate_asset* asset) PALPATE_NOEXCEPT;

/* Copies bytes [size] to the first multiple of 64 within room [room_bytes]; size + 63 is always
   enough. Returns where, for palpate_open; null when it does not fit. For bytes that lie anywhere,
   as in a string or a packet. */
PALPATE_API void* palpate_copy_aligned(void* room, uint64_t room_bytes, const void* bytes,
                                       uint64_t size) PALPATE_NOEXCEPT;

/* Makes a contact for a tool: in the air, its sums zero. Call again to start anew, and when another
   asset takes the place of the one that the contact was used with.
   PALPATE_OK, PALPATE_NULL_ARGUMENT or PALPATE_TOOL_WRONG (the contact is then not started). */
PALPATE_API palpate_status palpate_start(palpate_contact* contact,
                                         const palpate_tool* tool) PALPATE_NOEXCEPT;

/* Ends contact and forgets where the tool was, as after a pause or a jump that was meant: the next
   tick only learns where the tool is. The sums stay. */
PALPATE_API palpate_status palpate_release(palpate_contact* contact) PALPATE_NOEXCEPT;

/* One tick of the tools on one body: contacts, in and out [count], 1 to PALPATE_MAX_BALLS with no
   more balls between them, in any order; tools may join and leave between ticks. Call it at
   any rate. The first tick only learns where the tools are. Contact begins where a tip or ball
   first touches on its straight path from the previous tick, at any speed up to max_step_m. One
   that starts inside the body has no force until it has come out.

   On an asset that couples (palpate_info.couples) the force on one ball moves the surface under the
   others: of the same tool, and of the others. Then the stored_J add up to what all store together,
   dissipated_J, refused_J and refused_ticks are of all tools, and tools are passive as a whole: one
   may return what another has put in. Inputs say the same body and the same dt_s. On other
   assets each tool is by itself. A tool that is refused is out of contact, and the others go on.

   Writes all of out whatever happens, each with its status, and returns the first that is not
   PALPATE_OK.
   Work of each ball, in evaluations of three curves (about 25 to 60 multiply-adds each): stick 2;
   slip at most 16 segments of 15 evaluations and 2 energies, usually one segment of 2 and 2; where
   the body sways or balls move each other at most 54 of these, usually 3 to 7; where it relaxes 2
   more. A first loading of a body that softens visits at most 96 triangles. In the air the tree
   boxes near the path, 2 log2(triangles) for a tip in free space and never more than 2 x triangles.
   No data-dependent loop is longer. */
PALPATE_API palpate_status palpate_tick(const palpate_asset* asset, palpate_contact* contacts,
                                        int32_t count, const palpate_input* in,
                                        palpate_output* out) PALPATE_NOEXCEPT;

/* Displacements by tools of vertices first to first + vertices - 1 of the surface, in metres and in
   the body's frame: displacement_m [3 vertices], x, y, z of each; add it to palpate_read_mesh's
   vertices. For the thread that draws. `contacts` [count] is a copy that the force thread made
   after a tick (a plain copy of the structures, handed over as the program likes); it is only read.
   All zero in the air. Continuous in the tools' places while they touch and slide. No vertex is
   left inside the one ball of a tool, or inside the ball that the curves were measured with where
   it is a tip; triangles between vertices may cut into it by about (edge length)^2 / (8 radius).
   The error that an asset states for it is shape_error of its meta_json. Work: of each ball at most
   9 test points' numbers once, then some 0.1 us a vertex. Vertices may be shared out over calls and
   threads. PALPATE_OK, PALPATE_NULL_ARGUMENT, PALPATE_ASSET_NOT_OPEN, PALPATE_NOT_STARTED,
   PALPATE_CONTACT_FOREIGN, PALPATE_COUNT_WRONG, PALPATE_NO_SHAPE or PALPATE_VERTICES_WRONG, which
   writes nothing; all others but a null displacement_m write zeros. */
PALPATE_API palpate_status palpate_deform(const palpate_asset* asset,
                                          const palpate_contact* contacts, int32_t count,
                                          int32_t first, int32_t vertices,
                                          float* displacement_m) PALPATE_NOEXCEPT;

/* Places of vertices first to first + vertices - 1 of the mesh of one's own that `palpate export
   --visual MESH` hung on the surface: place_m [3 vertices], in metres and in the body's frame, in
   the order in which the mesh's file lists them. displacement_m [3 palpate_info.vertices]: of the
   whole surface, as palpate_deform fills it; null: at rest. A vertex keeps its offset from the
   triangle that it hangs on, and turns with it. Work: 50 ns a vertex. Vertices may be shared out
   over calls and threads. PALPATE_OK, PALPATE_NULL_ARGUMENT, PALPATE_ASSET_NOT_OPEN or
   PALPATE_VERTICES_WRONG, which all write nothing but PALPATE_OK. */
PALPATE_API palpate_status palpate_place_visual(const palpate_asset* asset,
                                                const float* displacement_m, int32_t first,
                                                int32_t vertices, float* place_m) PALPATE_NOEXCEPT;

/* Checks that the library is the one of this header. Structures grow within what they
   reserve; where that is not enough PALPATE_ABI is raised. */
static inline palpate_status palpate_header_fits(void) {
  const uint32_t bytes[8] = {sizeof(palpate_asset), sizeof(palpate_contact), sizeof(palpate_pose),
                             sizeof(palpate_tool),  sizeof(palpate_input),   sizeof(palpate_output),
                             sizeof(palpate_info),  sizeof(palpate_mesh)};
  return palpate_sizes_fit(PALPATE_ABI, bytes);
}

/* The commonest tools and inputs, ready to pass. */
static inline palpate_tool palpate_ball(double radius_m) {
  palpate_tool tool;
  unsigned char* bytes = (unsigned char*)&tool;
  for (size_t i = 0; i < sizeof tool; ++i) bytes[i] = 0;
  tool.balls = 1;
  tool.radius_m[0] = radius_m;
  return tool;
}
static inline palpate_indenter palpate_ball_indenter(double radius_m) {
  palpate_indenter indenter;
  unsigned char* bytes = (unsigned char*)&indenter;
  for (size_t i = 0; i < sizeof indenter; ++i) bytes[i] = 0;
  indenter.round_end_m = radius_m;
  return indenter;
}
static inline palpate_tool palpate_tip(void) { return palpate_ball(0); }
static inline palpate_input palpate_input_at(double x_m, double y_m, double z_m, double dt_s) {
  const palpate_input in = {
      {{x_m, y_m, z_m}, {1, 0, 0, 0}}, {{0, 0, 0}, {1, 0, 0, 0}}, dt_s, 0, {0}};
  return in;
}

#ifdef __cplusplus
} /* extern "C" */
#endif
#endif
