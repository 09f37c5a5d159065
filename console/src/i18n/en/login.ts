export default {
  'login.title': 'Log in',
  'login.user': 'User',
  'login.password': 'Password',
  'login.enter': 'Log in',
  'login.wait': 'Wait {s} s before the next try',
};
