// kilotouch for Unity and other C#: the declarations of kilotouch.h. Put libkilotouch.so into Assets/Plugins.
// World: right-handed, metres. Unity's is left-handed with y up: a place (x, y, z) there is (x, z, y) here, a turn
// (x, y, z, w) is (-x, -z, -y, w), and torques change as turns do.
using System;
using System.Runtime.InteropServices;

public static class Kilotouch {
  const string Library = "kilotouch";
  public const uint ApiVersion = 1;

  public enum Status { Ok = 0, Input = 1, Run = 2, Misuse = 3 }

  [Flags]
  public enum Flags : uint {
    EventsExhausted = 1, LeftPatch = 2, LostAnchor = 4, RigidContact = 8, NotFinite = 16, ContactsExhausted = 32,
    PushedOut = 64, StaleModel = 128, BodyFailed = 256, NoModel = 512, BadPose = 1024, LateTick = 2048, Gated = 4096, Slewed = 8192,
    StalePose = 16384, OnApron = 32768, Unrefined = 65536,
    WorkExhausted = 131072
  }

  [StructLayout(LayoutKind.Sequential)]
  public struct Pose {
    public uint size, buttons;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] x;     // m
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 4)] public double[] turn;  // w x y z

    public static Pose At(double x, double y, double z) {
      return new Pose {
        size = (uint)Marshal.SizeOf(typeof(Pose)), x = new[] { x, y, z }, turn = new[] { 1.0, 0, 0, 0 }
      };
    }
  }

  public enum Health { Ok = 0, Stale = 1, Gone = 2, Fault = 3, Uncalibrated = 4 }

  [StructLayout(LayoutKind.Sequential)]
  public struct Device {
    public uint size, buttons;
    public Health health;
    public uint delays;
    public double age, delay;  // s

    public static Device WithPoseOf(double age) {
      return new Device { size = (uint)Marshal.SizeOf(typeof(Device)), age = age };
    }
  }

  [StructLayout(LayoutKind.Sequential)]
  public struct Frame {
    public uint size;
    public Flags flags;
    public double t;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] force;   // N
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] torque;  // N m
    public double f_n, f_t;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] normal;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] point;
    public double gap;
    public int mode, triangle, contacts, model_frame;

    public static Frame Empty() {
      return new Frame {
        size = (uint)Marshal.SizeOf(typeof(Frame)), force = new double[3], torque = new double[3],
        normal = new double[3], point = new double[3]
      };
    }
  }

  [StructLayout(LayoutKind.Sequential)]
  public struct Stats {
    public uint size;
    public int refreshes, linearized_tick, dof, patch_vertices;
    public double refresh_ms, late_ticks, expected_force_error, certified_error, fineness, force_factor;
  }

  [StructLayout(LayoutKind.Sequential, CharSet = CharSet.Ansi)]
  public struct Finding {
    public uint size;
    public int weight;
    public double value, limit;
    [MarshalAs(UnmanagedType.ByValTStr, SizeConst = 512)] public string what;
    [MarshalAs(UnmanagedType.ByValTStr, SizeConst = 64)] public string where;
    [MarshalAs(UnmanagedType.ByValTStr, SizeConst = 256)] public string cure;
    [MarshalAs(UnmanagedType.ByValTStr, SizeConst = 64)] public string cure_key;
    [MarshalAs(UnmanagedType.ByValTStr, SizeConst = 64)] public string cure_value;
  }

  [DllImport(Library)] public static extern IntPtr kt_version();
  [DllImport(Library)] public static extern uint kt_api_version();
  [DllImport(Library)] public static extern IntPtr kt_last_error();
  [DllImport(Library)] public static extern IntPtr kt_open_scene(string file, string[] settings, UIntPtr count);
  [DllImport(Library)] public static extern IntPtr kt_open_mesh(string file, string[] settings, UIntPtr count);
  [DllImport(Library)]
  public static extern IntPtr kt_open_arrays(
      double[] xyz, UIntPtr nodes, int[] triangles, UIntPtr num_triangles, int[] tetrahedra, UIntPtr num_tetrahedra,
      string[] settings, UIntPtr count);
  [DllImport(Library)] public static extern void kt_close(IntPtr touch);
  [DllImport(Library)] public static extern int kt_num_tools(IntPtr touch);
  [DllImport(Library)] public static extern Status kt_place(IntPtr touch, [In] Pose[] tools, UIntPtr count);
  [DllImport(Library)] public static extern Status kt_start(IntPtr touch);
  [DllImport(Library)] public static extern Status kt_stop(IntPtr touch);
  [DllImport(Library)]
  public static extern Status kt_tick(
      IntPtr touch, [In] Pose[] tools, UIntPtr count, [In, Out] Frame[] frames);
  [DllImport(Library)]
  public static extern Status kt_tick_after(
      IntPtr touch, [In] Pose[] tools, UIntPtr count, double seconds, [In, Out] Frame[] frames);
  [DllImport(Library)]
  public static extern Status kt_tick_device(
      IntPtr touch, [In] Pose[] tools, [In] Device[] devices, UIntPtr count, double seconds, [In, Out] Frame[] frames);
  [DllImport(Library)]
  public static extern Status kt_triangles(
      IntPtr touch, uint[] result, UIntPtr room, out UIntPtr needed);
  [DllImport(Library)]
  public static extern Status kt_positions(
      IntPtr touch, float[] xyz, UIntPtr room, out UIntPtr needed);
  [DllImport(Library)] public static extern Status kt_set_number(IntPtr touch, string key, double value);
  [DllImport(Library)] public static extern Status kt_set_word(IntPtr touch, string key, string word);
  [DllImport(Library)] public static extern Status kt_get_number(IntPtr touch, string key, out double value);
  [DllImport(Library)]
  public static extern Status kt_warnings(IntPtr touch, byte[] lines, UIntPtr room, out UIntPtr needed);
  [DllImport(Library)]
  public static extern Status kt_finding_at(IntPtr touch, UIntPtr index, ref Finding result, out UIntPtr count);
  [DllImport(Library)] public static extern Status kt_stats_of(IntPtr touch, ref Stats result);

  public static string LastError() { return Marshal.PtrToStringAnsi(kt_last_error()); }
}
