/* kilotouch for C, and for programs that call C, as Unity, Unreal, ROS, MATLAB, Julia, Python's ctypes.
 *
 * A body is opened from a scene file or a mesh, with settings as on the command line ("contact.mu=0.3"). Tools are
 * ticked with poses and give forces. SI units, world frame. Nothing throws, exits or prints.
 *
 * Symbols are never removed or changed within one KT_API_VERSION, and structs only grow at their end. Each struct begins
 * with `size`, which the caller sets to sizeof. The library reads and writes no more than that.
 *
 * One thread at a time ticks a kt_touch. kt_set_*, kt_get_*, kt_stats_of and kt_positions may be called from others
 * meanwhile. kt_last_error belongs to the calling thread. */
#ifndef KILOTOUCH_H
#define KILOTOUCH_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define KT_API __attribute__((visibility("default")))
#else
#define KT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define KT_API_VERSION 1

typedef struct kt_touch kt_touch;

/* KT_INPUT means that a file, a setting or a value is wrong, KT_RUN that the simulation failed, KT_MISUSE that the call
 * itself is wrong, as one with a null pointer or one that comes too late. kt_last_error() has the reason in one line. */
typedef enum kt_status { KT_OK = 0, KT_INPUT = 1, KT_RUN = 2, KT_MISUSE = 3 } kt_status;

/* The reasons of a force, bits of kt_frame.flags. */
enum {
  KT_EVENTS_EXHAUSTED = 1,   /* more impacts in one tick than are resolved */
  KT_LEFT_PATCH = 2,         /* the contact lies on the edge of the local model */
  KT_LOST_ANCHOR = 4,        /* a refresh brought a local model that does not hold the contact */
  KT_RIGID_CONTACT = 8,      /* contact with a part that cannot move */
  KT_NOT_FINITE = 16,        /* the local model left the finite numbers and was reset, the force is zero */
  KT_CONTACTS_EXHAUSTED = 32,/* as many places touch at once as are resolved */
  KT_PUSHED_OUT = 64,        /* the tool was inside, and the body is being pushed off it */
  KT_STALE_MODEL = 128,      /* the body has not followed for long */
  KT_BODY_FAILED = 256,      /* the body's simulation has ended with an error, the last local model goes on */
  KT_NO_MODEL = 512,         /* nothing is touched, since there is no local model yet */
  KT_BAD_POSE = 1024,        /* the pose was not finite, and the tool stayed where it was */
  KT_LATE_TICK = 2048,       /* more time had passed than is caught up with in one call */
  /* Flags of kt_tick_device. */
  KT_GATED = 4096,           /* the gate was not fully open, the force is a part of the body's, or none */
  KT_SLEWED = 8192,          /* the force was held back from changing faster than the device is allowed */
  KT_STALE_POSE = 16384,     /* the device's pose was too old, or the device was not there */
  KT_ON_APRON = 32768,       /* the contact lies outside the local model, on the body around it, with a coarse force */
  KT_UNREFINED = 65536,      /* the contact lies beside the refined cells, the force is that of the cells as they are */
  KT_WORK_EXHAUSTED = 131072 /* the contact solver stopped at the work limit of a tick, and goes on in the next one */
};

enum { KT_FREE = 0, KT_STICK = 1, KT_SLIDE = 2, KT_FRICTIONAL_SLIDE = 3 }; /* kt_frame.mode */

typedef struct kt_pose {
  uint32_t size;    /* sizeof(kt_pose) */
  uint32_t buttons; /* not read */
  double x[3];      /* reference point [m] */
  double turn[4];   /* unit quaternion w x y z, from the tool's frame to the world's */
} kt_pose;

enum { KT_DEVICE_OK = 0, KT_DEVICE_STALE = 1, KT_DEVICE_GONE = 2, KT_DEVICE_FAULT = 3, KT_DEVICE_UNCALIBRATED = 4 };

typedef struct kt_device {
  uint32_t size;    /* sizeof(kt_device) */
  uint32_t buttons; /* bit 0 is the first */
  int32_t health;   /* KT_DEVICE_OK and so on */
  uint32_t delays;  /* how many were measured so far, for the next, 0 for none */
  double age;       /* age of the pose [s] */
  double delay;     /* from a force that was written until it acted, as it was measured last [s] */
} kt_device;

typedef struct kt_frame {
  uint32_t size;  /* sizeof(kt_frame) */
  uint32_t flags; /* KT_LEFT_PATCH and so on */
  double t;       /* end of the tick [s] */
  double force[3], torque[3]; /* on the tool [N], about its reference point [N m] */
  double f_n, f_t;            /* normal and tangential parts [N] */
  double normal[3], point[3]; /* at the contact that carries most, unit from the body towards the tool, and [m] */
  double gap;                 /* smallest of a contact [m], infinite where nothing is touched */
  int32_t mode, triangle;     /* KT_STICK and so on, and a triangle of the body's surface, -1 for none */
  int32_t contacts, model_frame;
} kt_frame;

typedef struct kt_stats {
  uint32_t size; /* sizeof(kt_stats) */
  int32_t refreshes, linearized_tick, dof, patch_vertices;
  double refresh_ms, late_ticks, expected_force_error, certified_error; /* NaN where not known */
  double fineness;     /* refined cells over the contact radius, NaN where none are refined */
  double force_factor; /* force to expect of the cells under the tools over the continuum's, NaN where not known */
} kt_stats;

enum { KT_NOTE = 0, KT_DOUBT = 1, KT_FAILURE = 2 };

typedef struct kt_finding {
  uint32_t size;         /* sizeof(kt_finding) */
  int32_t weight;        /* KT_NOTE says nothing against the forces, with KT_FAILURE they are not those of the scene */
  double value, limit;   /* the measured value, and the one from which on it is told, NaN for none */
  char what[512];        /* the quantity, its value, its limit, with a zero at the end as all texts here, cut where it is longer */
  char where[64];        /* key of the scene that it is about, empty for none */
  char cure[256];        /* the best one, empty where none is known */
  char cure_key[64], cure_value[64]; /* its setting, for kt_set_number and kt_set_word, empty where it is none */
} kt_finding;

KT_API const char* kt_version(void);
KT_API uint32_t kt_api_version(void);
KT_API const char* kt_last_error(void); /* error of this thread's last call that failed, never null */

/* These open a body, and give null where that failed. `settings` are `count` texts KEY=VALUE, as --set on the command line (docs/scene.md). */
KT_API kt_touch* kt_open_scene(const char* file, const char* const* settings, size_t count);
KT_API kt_touch* kt_open_mesh(const char* file, const char* const* settings, size_t count);
/* xyz has 3 numbers a node [m], triangles 3 indices each, counter-clockwise from outside, tetrahedra 4 each, turned
 * either way, may be none. With tetrahedra there may be no triangles, and their boundary is the surface. */
KT_API kt_touch* kt_open_arrays(const double* xyz, size_t nodes, const int32_t* triangles, size_t num_triangles,
                                const int32_t* tetrahedra, size_t num_tetrahedra, const char* const* settings,
                                size_t count);
KT_API void kt_close(kt_touch* touch); /* null does nothing */

KT_API int32_t kt_num_tools(const kt_touch* touch); /* 1 or 2, and 0 for null */
/* Poses of the tools before the first tick. */
KT_API kt_status kt_place(kt_touch* touch, const kt_pose* tools, size_t count);
/* The body in a thread of its own from now on. Call it after kt_place, before the first tick. Without it, ticks refresh the body
 * themselves, deterministic, and some take tens of milliseconds. */
KT_API kt_status kt_start(kt_touch* touch);
KT_API kt_status kt_stop(kt_touch* touch);
/* One tick of the haptic rate (local.rate_hz), with a frame a tool. After kt_start no allocation, lock or clock. */
KT_API kt_status kt_tick(kt_touch* touch, const kt_pose* tools, size_t count, kt_frame* frames);
/* The same after `seconds`, >= 0, for a loop that does not keep the rate. */
KT_API kt_status kt_tick_after(kt_touch* touch, const kt_pose* tools, size_t count, double seconds, kt_frame* frames);

/* One tick for devices that a person holds (tool.path.device of the scene, name pushed, with its limits, else 3 N). The
 * frames' forces and torques are to be written to the devices now. They are finite, within limits and slew, passive,
 * zero until a gate has opened and 20 ms after the last fresh pose (docs/devices.md). Call it each period of
 * local.rate_hz. Poses are in the world's frame, forces at the device's side of force_scale.
 * `seconds` is the time since the last call. */
KT_API kt_status kt_tick_device(kt_touch* touch, const kt_pose* tools, const kt_device* devices, size_t count,
                                double seconds, kt_frame* frames);

/* The surface for drawing, indices once, positions as often as wanted. `out` has `room` numbers. `needed` is filled. */
KT_API kt_status kt_triangles(kt_touch* touch, uint32_t* out, size_t room, size_t* needed);
KT_API kt_status kt_positions(kt_touch* touch, float* xyz, size_t room, size_t* needed);

/* Settings that may change meanwhile, as contact.mu, object.model.young, local.reducer ... (docs/embedding.md). */
KT_API kt_status kt_set_number(kt_touch* touch, const char* key, double value);
KT_API kt_status kt_set_word(kt_touch* touch, const char* key, const char* word);
KT_API kt_status kt_get_number(const kt_touch* touch, const char* key, double* value);
/* Facts against the forces so far, a line each, with a zero at the end. `out` has `room` characters. `needed` is filled,
 * 1 where there is no fact. From any thread, with kt_tick_device from the ticking one. */
KT_API kt_status kt_warnings(const kt_touch* touch, char* out, size_t room, size_t* needed);
/* The same one by one. `count` is filled with their number. `out` is left as it is where `index` is not below it, and may
 * be null at index 0. */
KT_API kt_status kt_finding_at(const kt_touch* touch, size_t index, kt_finding* out, size_t* count);
KT_API kt_status kt_stats_of(const kt_touch* touch, kt_stats* out);

#ifdef __cplusplus
}
#endif

#endif
